// Procedural surface colours: rich detail down to the size of a pixel and none below it.
//
// Takes a point in an object's own axes (so that texture moves with the object), a position on its face, and the size
// of a pixel there; gives linear reflectance. Noise is band-limited: octaves shorter than about two pixels fade out.
// Hard edges (bricks, checks, windows) are left to supersampling and fade to their mean when they become too small.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace ldp {

enum class Pattern : uint8_t { plain, mottled, bricks, checks, planks, leaf, cloth, facade, shingles, picture };

struct Material {
  Pattern pattern = Pattern::mottled;
  Eigen::Vector3f dark = {0.1F, 0.1F, 0.1F}, light = {0.5F, 0.5F, 0.5F};  // linear reflectance
  Eigen::Vector3f accent = {0.6F, 0.6F, 0.55F};                           // mortar, veins, window panes
  float size_m = 0.25F;                                                   // longest wavelength, or the pattern's cell
  uint32_t seed = 0;
};

struct TexturePoint {
  Eigen::Vector3d local = Eigen::Vector3d::Zero();  // object axes, metres
  Eigen::Vector2d face = Eigen::Vector2d::Zero();   // on the surface, metres, second axis up
  double pixel_m = 0;                               // size of a pixel at the point
};

Eigen::Vector3f reflectance(const Material& material, const TexturePoint& point);

// Fractal value noise about 0, mostly within -1 .. 1, with wavelengths from `wavelength_m` down to the pixel.
float fractal_noise(const Eigen::Vector3d& point, double wavelength_m, double pixel_m, uint32_t seed);

}  // namespace ldp
