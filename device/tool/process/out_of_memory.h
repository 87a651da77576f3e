// When memory ends where nothing can catch it: in the threads of a library, or in a destructor, whose std::bad_alloc
// ends the program.
#pragma once

#include <string>

namespace ldp {

// From now on such an end says `line`, leaves no temporary files and has exit status 75. What else ends the program
// unasked is told as ever, by the C++ library and a signal.
void say_when_memory_ends(const std::string& line);

}  // namespace ldp
