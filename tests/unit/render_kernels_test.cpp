#include "core/view/raster/raster_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "core/base/plane.h"

namespace ldp::view::kernels {
namespace {

// A lattice of vertices that jitter around a grid of `pitch` sub-pixels, without folds; at multiples of `step`.
class Lattice {
 public:
  Lattice(int pitch, unsigned seed, int step = 1) {
    std::mt19937 random(seed);
    const auto between = [&](int low, int high) {
      return low + static_cast<int>(random() % static_cast<unsigned>(high - low + 1));
    };
    for (size_t y = 0; y < kRows; ++y)
      for (size_t x = 0; x <= kRowQuads; ++x) {
        const int at_x = (static_cast<int>(x) * pitch + between(-pitch / 3, pitch / 3) + 1000) / step * step;
        const int at_y = (static_cast<int>(y) * pitch + between(-pitch / 3, pitch / 3) + 1000) / step * step;
        rows_[y].x[x] = static_cast<float>(at_x);
        rows_[y].y[x] = static_cast<float>(at_y);
        rows_[y].inverse_z[x] = 0.001F * static_cast<float>(between(100, 900));
        colours_[y][x] = static_cast<Rgba>(random());
      }
  }

  QuadRow quads(const Kernels& kernels, size_t y) {
    QuadRow row;
    for (size_t k = 0; k < 4; ++k) {
      const size_t r = y + (k >> 1), column = k & 1;
      kernels.interleave(rows_[r], colours_[r].data(), kRowQuads + 1, 0, vertices_[r].data());
      row.vertices[k] = vertices_[r].data() + column;
      row.x[k] = rows_[r].x + column;
      row.y[k] = rows_[r].y + column;
      row.inverse_z[k] = rows_[r].inverse_z + column;
    }
    return row;
  }

  static constexpr size_t kRows = 9;

 private:
  std::array<ScreenRow, kRows> rows_;
  std::array<std::array<Rgba, kRowQuads + 1>, kRows> colours_;
  std::array<std::array<Vertex, kRowQuads + 1>, kRows> vertices_;
};

constexpr Clip kClip = {3, 150, 60};

std::vector<Fragment> hits_of(const Kernels& kernels, const QuadRow& row, Candidates& candidates) {
  std::vector<Fragment> out(Candidates::kRoom + Candidates::kPadding);
  kernels.find_hits(row, candidates, out.data());
  out.resize(static_cast<size_t>(candidates.count));
  return out;
}

// Calls use(row, quad, x, y, fragment) for every pixel of every box, a quad at a time.
template <class Use>
void for_all_pixels(const Kernels& kernels, Lattice& lattice, Use use) {
  for (size_t y = 0; y + 1 < Lattice::kRows; ++y) {
    const QuadRow row = lattice.quads(kernels, y);
    Boxes boxes;
    kernels.find_boxes(row, 0, kRowQuads, kClip, boxes);
    for (int i = 0; i < kRowQuads; ++i) {
      if ((boxes.some >> i & 1) == 0) continue;
      Candidates candidates;
      for (int py = boxes.y[i]; py <= boxes.bottom[i]; ++py)
        for (int px = boxes.x[i]; px <= boxes.right[i]; ++px) {
          candidates.pixel[candidates.count] = px | py << 16;
          candidates.quad[candidates.count++] = i;
        }
      const std::vector<Fragment> hits = hits_of(kernels, row, candidates);
      for (size_t k = 0; k < hits.size(); ++k)
        use(row, i, candidates.pixel[k] & 0xFFFF, candidates.pixel[k] >> 16, hits[k]);
    }
  }
}

class RenderKernels : public testing::TestWithParam<const Kernels*> {};
INSTANTIATE_TEST_SUITE_P(InstructionSets, RenderKernels, testing::Values(&best(), &plain()));

TEST_P(RenderKernels, give_every_pixel_of_a_lattice_to_exactly_one_quad) {
  for (const auto& [pitch, step] : {std::pair(40, 1), {150, 1}, {256, 1}, {300, 1}, {512, 1}, {1000, 1}, {512, 128}}) {
    Lattice lattice(pitch, 7, step);
    Plane<int> owners(kClip.x1 + 1, kClip.y1 + 1, 0);
    for_all_pixels(*GetParam(), lattice, [&](const QuadRow&, int, int x, int y, const Fragment& f) {
      if (f.inverse_z != kNothing) ++owners.at(x, y);
    });
    const int first = 1000 / kSubPx + pitch / kSubPx + 3;
    const int last_x = std::min(kClip.x1, (1000 + (kRowQuads - 1) * pitch) / kSubPx - 2);
    const int last_y = std::min(kClip.y1, (1000 + (static_cast<int>(Lattice::kRows) - 2) * pitch) / kSubPx - 2);
    for (int y = 0; y <= kClip.y1; ++y)
      for (int x = kClip.x0; x <= kClip.x1; ++x) {
        ASSERT_LE(owners.at(x, y), 1) << pitch << ": " << x << ", " << y;
        if (x >= first && x <= last_x && y >= first && y <= last_y) {
          ASSERT_EQ(owners.at(x, y), 1) << x << ", " << y;
        }
      }
  }
}

TEST_P(RenderKernels, find_in_floats_what_doubles_find) {
  const Kernels& kernels = *GetParam();
  for (const int pitch : {40, 256, 700, 1200}) {
    Lattice lattice(pitch, 11);
    int inside = 0;
    for_all_pixels(kernels, lattice, [&](const QuadRow& row, int quad, int x, int y, const Fragment& f) {
      const Fragment truth = kernels.find_hit(row, quad, x, y);
      ASSERT_EQ(f.inverse_z == kNothing, truth.inverse_z == kNothing);
      if (f.inverse_z == kNothing) return;
      ++inside;
      ASSERT_NEAR(f.inverse_z, truth.inverse_z, 1e-6);
      for (int channel = 0; channel < 32; channel += 8)
        ASSERT_NEAR(static_cast<int>(f.colour >> channel & 255), static_cast<int>(truth.colour >> channel & 255), 1);
    });
    EXPECT_GT(inside, 5);
  }
}

TEST(RenderKernelsAtHand, give_the_same_bytes_as_the_plain_ones) {
  for (const int pitch : {30, 220, 256, 400, 900}) {
    Lattice lattice(pitch, 5);
    std::vector<Fragment> all[2];
    int which = 0;
    for (const Kernels* kernels : {&best(), &plain()}) {
      for_all_pixels(*kernels, lattice,
                     [&](const QuadRow&, int, int, int, const Fragment& f) { all[which].push_back(f); });
      ++which;
    }
    ASSERT_EQ(all[0].size(), all[1].size());
    for (size_t i = 0; i < all[0].size(); ++i) {
      ASSERT_EQ(all[0][i].inverse_z, all[1][i].inverse_z);
      if (all[0][i].inverse_z != kNothing) {
        ASSERT_EQ(all[0][i].colour, all[1][i].colour);
      }
    }
  }
}

TEST(RenderKernelsAtHand, collect_the_corners_that_indices_name_at_every_number_of_quads) {
  std::mt19937 random(4);
  std::vector<Vertex> vertices(100);
  for (size_t i = 0; i < vertices.size(); ++i) {
    const auto number = static_cast<float>(i);
    vertices[i] = {number, number + 1000, number + 2000, static_cast<Rgba>(random())};
  }
  std::vector<IndexedQuad> quads(kRowQuads);
  for (IndexedQuad& quad : quads)
    for (uint16_t& corner : quad.corner) corner = static_cast<uint16_t>(random() % vertices.size());
  for (int count = 1; count <= kRowQuads; ++count) {
    QuadTable table;
    best().collect(vertices.data(), quads.data(), count, table);
    for (int i = 0; i < (count + 7) / 8 * 8; ++i)
      for (int k = 0; k < 4; ++k) {
        const Vertex& named = vertices[quads[static_cast<size_t>(std::min(i, count - 1))].corner[k]];
        ASSERT_EQ(table.x[k][i], named.x) << count << ", " << i;
        ASSERT_EQ(table.y[k][i], named.y);
        ASSERT_EQ(table.inverse_z[k][i], named.inverse_z);
        ASSERT_EQ(table.vertices[k][i].x, named.x);
        ASSERT_EQ(table.vertices[k][i].colour, named.colour);
      }
  }
}

TEST(RenderKernelsAtHand, project_the_same_at_every_number_of_vertices) {
  std::mt19937 random(3);
  const auto number = [&](double low, double high) {
    return static_cast<float>(low + (high - low) * static_cast<double>(random() % 10000) / 10000);
  };
  constexpr size_t kMost = kRowQuads + 1;
  std::array<std::array<float, kMost>, 7> in;
  for (auto& column : in)
    for (float& value : column) value = number(-1, 1);
  for (float& z : in[2]) z = number(-0.2, 1.5);
  for (float& w : in[6]) w = number(0, 2);
  const Rays rays = {in[0].data(), in[1].data(), in[2].data(), in[3].data(), in[4].data(), in[5].data()};
  const Lens plain_lens = {500, 510, 400, 300, 0, 0, 0, 0, 1e9F, false};
  const Lens lens = {500, 510, 400, 300, 0.1F, -0.02F, 0.001F, 0.002F, 4, true};
  const float v[3] = {0.1F, -0.2F, 0.05F};
  for (const Lens& l : {plain_lens, lens})
    for (int count = 1; count <= static_cast<int>(kMost); ++count) {
      ScreenRow a, b;
      const int first = static_cast<int>(kMost) - count;
      best().project(rays, v, in[6].data(), l, count, first, a);
      for (int i = 0; i < count; ++i) {
        const auto k = static_cast<size_t>(i);
        const Rays one = {&in[0][k], &in[1][k], &in[2][k], &in[3][k], &in[4][k], &in[5][k]};
        plain().project(one, v, &in[6][k], l, 1, 0, b);
        ASSERT_EQ(a.x[first + i], b.x[0]) << count << ", " << i;
        if (b.x[0] == kOffScreen) continue;
        ASSERT_EQ(a.y[first + i], b.y[0]);
        ASSERT_EQ(a.inverse_z[first + i], b.inverse_z[0]);
        ASSERT_EQ(a.x[first + i], std::round(a.x[first + i]));
      }
    }
}

}  // namespace
}  // namespace ldp::view::kernels
