// The order of a build's stages, apart from what each does: build() gives the real ones, a test gives others.
//
// A type of stages has, as they come first:
//   find_cameras()                   poses and sparse points
//   lay_out()                        arc, grid, upright photos
//   bool parallax()                  whether the photos were taken from more than one place
//   one_far_layer()                  what stands for all layers where they were not
//   begin_iteration(bool last)       of finding layers
//   bool find_layer(index, name)     front to back from index 0; false: nothing is there
//   end_iteration()                  what was found hides voxels from cameras in the next one
//   check_layers()                   throws where no layer was found
//   split_columns()                  from the columns of depth to those of colour
//   choose_photographs()             the colour cut
//   assemble()                       the result
#pragma once

#include <string>

namespace ldp {

// Only the last of the iterations looks behind the front (paper 3.3.4).
template <typename Stages>
void find_layers_in_order(Stages& stages, int layers, int iterations) {
  for (int iteration = 1; iteration <= iterations; ++iteration) {
    const bool last = iteration == iterations;
    stages.begin_iteration(last);
    for (int index = 0; index < (last ? layers : 1); ++index) {
      const std::string name = "layer " + std::to_string(index + 1) + " iteration " + std::to_string(iteration);
      if (!stages.find_layer(index, name)) break;
    }
    stages.end_iteration();
  }
}

template <typename Stages>
auto run_in_order(Stages& stages, int layers, int iterations) {
  stages.find_cameras();
  stages.lay_out();
  if (stages.parallax())
    find_layers_in_order(stages, layers, iterations);
  else
    stages.one_far_layer();
  stages.check_layers();
  stages.split_columns();
  stages.choose_photographs();
  return stages.assemble();
}

}  // namespace ldp
