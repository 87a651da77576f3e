ldp_test(around_test SOURCES around_test.cpp
  SLOW_EMULATED Around.FilesTellPlayersWhatTheyHold:Around.FromTheAxisEverythingIsWhereItStands:Around.TwoEyesSeeItApartByTheirDistance
  USES ldp_export ldp_view ldp_photos ${MD_LIBRARY})
