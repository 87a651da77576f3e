ldp_test(slender_things_test SOURCES slender_things_test.cpp ../bench/edges/slender_things.cpp
  NATIVE_ONLY SlenderThings.AreOfAllWidthsInTheSceneOfRailings USES ldp_view ldp_sim_scene)
