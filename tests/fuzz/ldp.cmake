# libFuzzer programs (clang): the whole file behind right checksums, and each decoder on its own.
#   cmake -B build/fuzz -G Ninja -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ -DLDP_FUZZERS=ON
#         -DLDP_SANITIZE=address,undefined,fuzzer-no-link -DLDP_DRIVERS=OFF -DLDP_BENCHMARKS=OFF
#   fuzz_ldp_file CORPUS tests/golden
foreach(target file depth alpha colour records)
  add_executable(fuzz_ldp_${target} fuzz_ldp_${target}.cpp)
  target_link_libraries(fuzz_ldp_${target} PRIVATE ldp_panorama ldp_photos ldp_defaults -fsanitize=fuzzer)
  endforeach()
