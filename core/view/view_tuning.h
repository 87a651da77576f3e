// Tuned constants of views that are no options: unit, meaning and range. What was measured: decisions.md.
#pragma once

namespace ldp::view {

// Surfaces (prepared_layer.h). What a slanted one may change from one pixel to the next: a share of its inverse depth
// (a surface seen at 88.5 degrees from its normal; 0.005 .. 0.05) plus this many pixels of parallax over one arc radius
// (0.5 .. 12).
constexpr float kSlant = 0.02F;
constexpr double kParallaxPx = 6;
// Pixels that look alike, all channels within so many levels (0 .. 32), are torn from so much parallax on (1 .. 4 times
// the above): what shows through a tear differs from both its sides, and a sheet over it does not.
constexpr int kAlikeLevels = 8;
constexpr double kAlikeParallaxPx = 24;

// Smoothing of codes (code_smoother.h).
constexpr float kFineShare = 0.1F;  // of a surface's parallax, below which steps do not show; 0 .. 1
constexpr int kSmoothings = 4;      // there and back each; 1 .. 16

// Underlay (underlay.h): pixels by which a surface goes on underneath another; 8 .. kTilePx.
constexpr int kReachPx = 20;

// What goes on beyond frames (frame_extension.h).
constexpr double kInsidePx = 10;   // nearer to a photograph's border depths are unsure; 0 .. 50
constexpr int kWitnessedRows = 4;  // of a surface that goes on, which two photographs could show; 1 .. 50
constexpr int kRowStep = 4;        // of the rows that are asked for that; 1 .. kWitnessedRows
constexpr int kBridge = 64;        // columns to either side within which a surface that they do show stands by others
constexpr float kBridgeShare = 0.1F;  // of its inverse depth by which the other may differ; 0 .. 0.5
constexpr int kMostMirrored = 160;    // rows of a surface that its continuation shows again, there and back; 1 ..
constexpr double kMostOfRows = 0.5;   // of the panorama's, that are made up at either end; 0 .. 1

// Framing of camera paths (framing.h). Views along the path that are looked at, and their width; share of their pixels
// that may show nothing; the closest view, in parts of its focal length, and the steps in which it is found; the shares
// of its way that a path keeps, of which the first is taken that is framed so.
constexpr int kGlances = 8, kGlancePx = 128;
constexpr double kUnseen = 0.004;  // 0 .. 0.1; a little under what full views may have
constexpr double kClosest = 1.6, kVeryClosest = 4;
constexpr int kZoomSteps = 4, kAimings = 3;
constexpr double kReaches[] = {1, 0.7, 0.5, 0.35, 0.2};

// Outlines (outlines.h). Inverse depths side by side bend at a step by more than this share of themselves (.03 .. .15)
// plus this many pixels of parallax over one arc radius (.5 .. 2); a pixel with at most so many of its eight neighbours
// on its surface (0 .. 2) is a speck.
constexpr float kOutlineShare = 0.06F;
constexpr double kOutlineParallaxPx = 0.75;
constexpr int kSpeckNeighbours = 1;

// Inpainting (inpainting.h).
constexpr int kSolidAlpha = 250;  // rounding of soft edges that cover each other leaves some pixels just under 255
constexpr int kRimPx = 2;         // rim pixels are this near to a hole; 1 .. 8

// Views drawn in parts; none of these changes a view.
constexpr int kStripPx = 200;  // few tiles cross strips, and a strip's buffers still fit a cache
// Tiles across of a panorama's strips that are made together: of those let go when a camera no longer sees them, and of
// those that stay.
constexpr int kStripTiles = 4, kRendererStripTiles = 8;

}  // namespace ldp::view
