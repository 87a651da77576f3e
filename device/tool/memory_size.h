// Options that take an amount of memory: 128M, 1G, 0.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace ldp {

// Bytes, with a unit where one follows. `zero_means` is what the refusal says of 0.
CLI::Validator memory_size(const std::string& zero_means);

}  // namespace ldp
