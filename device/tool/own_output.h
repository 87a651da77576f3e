// What may be written over: a file that is there already is replaced only by another of its own kind, told by what is
// in it. A slip of the hand must cost no photo of a sweep, record of a capture, or cameras and films of another
// program.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace ldp {

enum class OutputKind { panorama, report, cameras, picture, mesh, cloud, viewer, film, summary };

constexpr const char* kRendered = "ldp render";  // told in every view and film: other ones are someone's own

constexpr const char* kSummaryTitle = "Layered depth panoramas: a summary";

// Whether this is what `ldp build --report` writes, of a build that was done or that failed.
bool is_report(const nlohmann::ordered_json& json);

// The kind that `ldp export` writes by the file's extension, which it must know.
OutputKind exported_kind(const std::filesystem::path& file);

// Throws BadInput when `file` could not be written (output.h), is named like a file of another kind, or is there, not
// empty and of another kind.
void check_output_file(const std::filesystem::path& file, OutputKind kind);

}  // namespace ldp
