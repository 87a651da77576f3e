# libFuzzer programs (clang): the whole file behind right checksums, and each decoder on its own.
#   cmake --preset asan && cmake --build build/asan --target fuzz_ldp_file && build/asan/tests/fuzz/fuzz_ldp_file tests/golden
foreach(target file depth alpha colour records)
  add_executable(fuzz_ldp_${target} fuzz_ldp_${target}.cpp)
  target_link_libraries(fuzz_ldp_${target} PRIVATE ldp_panorama ldp_photos ldp_defaults -fsanitize=fuzzer)
endforeach()
