// The order of a build's stages, with stages that only tell that they were called.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "core/pipeline/stage_order.h"

namespace ldp {
namespace {

using testing::ElementsAre;

using Calls = std::vector<std::string>;

struct ToldStages {
  bool has_parallax = true;
  int layers_there = 8;        // in the scene
  std::string throws_in = {};  // the call that fails
  std::vector<std::string> calls = {};

  void tell(const std::string& call) {
    calls.push_back(call);
    if (call == throws_in) throw std::runtime_error(call);
  }
  void find_cameras() { tell("cameras"); }
  void lay_out() { tell("lay out"); }
  bool parallax() const { return has_parallax; }
  void one_far_layer() { tell("one far layer"); }
  void begin_iteration(bool last) { tell(last ? "last iteration" : "iteration"); }
  bool find_layer(int index, const std::string& name) {
    tell(name);
    return index < layers_there;
  }
  void end_iteration() { tell("end"); }
  void check_layers() { tell("check"); }
  void split_columns() { tell("columns"); }
  void choose_photographs() { tell("photographs"); }
  int assemble() {
    tell("assemble");
    return 7;
  }
};

Calls calls_of(ToldStages stages, int layers, int iterations) {
  EXPECT_EQ(run_in_order(stages, layers, iterations), 7);
  return stages.calls;
}

TEST(Pipeline, CamerasThenLayersFrontToBackThenColours) {
  EXPECT_THAT(calls_of({}, 3, 1),
              ElementsAre("cameras", "lay out", "last iteration", "layer 1 iteration 1", "layer 2 iteration 1",
                          "layer 3 iteration 1", "end", "check", "columns", "photographs", "assemble"));
}

TEST(Pipeline, OnlyTheLastIterationLooksBehindTheFront) {
  EXPECT_THAT(calls_of({}, 2, 3),
              ElementsAre("cameras", "lay out", "iteration", "layer 1 iteration 1", "end", "iteration",
                          "layer 1 iteration 2", "end", "last iteration", "layer 1 iteration 3", "layer 2 iteration 3",
                          "end", "check", "columns", "photographs", "assemble"));
}

TEST(Pipeline, NothingIsSoughtBehindWhereNothingWasFound) {
  EXPECT_THAT(calls_of({.layers_there = 1}, 4, 1),
              ElementsAre("cameras", "lay out", "last iteration", "layer 1 iteration 1", "layer 2 iteration 1", "end",
                          "check", "columns", "photographs", "assemble"));
}

TEST(Pipeline, WithoutParallaxOneFarLayerStandsForAll) {
  EXPECT_THAT(calls_of({.has_parallax = false}, 3, 2),
              ElementsAre("cameras", "lay out", "one far layer", "check", "columns", "photographs", "assemble"));
}

TEST(Pipeline, NothingFollowsAStageThatFails) {
  ToldStages whole;
  run_in_order(whole, 2, 2);
  for (size_t i = 0; i < whole.calls.size(); ++i) {
    ToldStages failing;
    failing.throws_in = whole.calls[i];
    EXPECT_THROW(run_in_order(failing, 2, 2), std::runtime_error);
    EXPECT_EQ(failing.calls.back(), failing.throws_in);
    EXPECT_LE(failing.calls.size(), i + 1);
  }
}

}  // namespace
}  // namespace ldp
