// The words for the verdict: names that programs read, and sentences for people. Nothing branches on them.
#pragma once

#include <string>

#include "core/verdict/sweep_quality.h"

namespace ldp {

const char* name_of(Grade grade);           // "good", "fair", "sweep_again"
const char* text_of(Grade grade);           // "sweep again" for people
const char* code_of(QualityReason reason);  // "blurred", ...

// What is wrong, where, and what to do: "the photos between 40 and 70 degrees are blurred: turn more slowly there".
std::string text_of(const QualityFinding& finding);

// All reasons in one line, each told once with all its places.
std::string reasons_of(const SweepQuality& quality);

// The whole verdict in one line: "good: new views of about 27 dB", "sweep again: ... ; ...". Of one before there is a
// panorama: "sweep again: the photos ...".
std::string text_of(const SweepQuality& quality);

}  // namespace ldp
