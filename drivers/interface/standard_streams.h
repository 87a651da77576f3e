// Standard input, output and error of a program that must not lose anything by them, and must not hang on them.
#pragma once

#include <string_view>

namespace ldp {

// Where a parent left one of the three closed it becomes /dev/null: else the next file that is opened would be it, a
// photo, say, and what is said would be written into that. To be called first of all.
void keep_standard_streams();

// A line on standard error, if it can be written now: nobody may read there, or the terminal was stopped, and the loop
// of a service waits for no reader. What does not fit into a pipe's smallest room (4096 bytes) is cut off.
void say(std::string_view line);

// Whether all that was printed on standard output has been written; errno says why not, 0 if it is unknown.
bool flush_standard_output();

}  // namespace ldp
