# The C interface. Its sources rather than the shared library, so that what random bytes reach is counted in one program.
add_executable(fuzz_library fuzz_library.cpp $<TARGET_OBJECTS:libldp>)
target_link_libraries(fuzz_library PRIVATE ldp_view ldp_captures ldp_defaults -fsanitize=fuzzer)
