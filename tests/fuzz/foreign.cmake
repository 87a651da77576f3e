# Photos and the files beside them. Each has a small corpus.
#   build/fuzz/tests/fuzz/fuzz_image NEW tests/fuzz/corpus/image
function(ldp_fuzz target)
  add_executable(fuzz_${target} fuzz_${target}.cpp)
  target_link_libraries(fuzz_${target} PRIVATE ${ARGN} ldp_defaults -fsanitize=fuzzer)
endfunction()
ldp_fuzz(image ldp_photos)
ldp_fuzz(exif ldp_photos)
ldp_fuzz(transforms ldp_captures)
ldp_fuzz(capture_notes ldp_captures)
