// Preloaded before a program, as a library's thread would be: one that no catch surrounds throws as soon as the folder
// named by LDP_FOLDER holds a hidden entry (what is not finished yet); what it throws, LDP_THROWS names.
#include <chrono>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>

namespace {

bool has_hidden(const char* folder) {
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().filename().string().starts_with('.')) return true;
  }
  return false;
}

// What compilers make of a destructor that is left by an exception while one further out would be caught.
struct EndsTheProgram {
  ~EndsTheProgram() { std::terminate(); }
};

[[gnu::noinline]] size_t end_before_it_is_caught(size_t length) {
  const EndsTheProgram last;
  return std::string(length, '.').find(',');
}

struct Thrower {
  Thrower() {
    const char *const folder = std::getenv("LDP_FOLDER"), *const what = std::getenv("LDP_THROWS");
    if (folder == nullptr || what == nullptr) return;
    std::thread([folder, text = std::string(what)] {
      while (!has_hidden(folder)) std::this_thread::sleep_for(std::chrono::milliseconds(2));
      if (text == "bad_alloc") throw std::bad_alloc();
      try {
        if (text == "in_a_destructor") end_before_it_is_caught(size_t{1} << 62);
      } catch (const std::bad_alloc&) {
      }
      throw std::runtime_error(text);
    }).detach();
  }
} thrower;

}  // namespace
