#pragma once
#include <stdexcept>
#include <string>

namespace foreview {

/// Something from outside (a file, an option, a message) is not as it must be. `what()` is one line:
/// "WHERE: WHY", where WHERE names the file (and line, "poses.txt:12"), option or topic, and WHY says what is wrong
/// and what was expected. The executable prints it and exits with 2.
class InputError : public std::runtime_error {
 public:
  InputError(const std::string& where, const std::string& why);
};

/// The graphics system refuses or lacks something that foreview needs. The executable prints it and exits with 3.
class GraphicsError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The user pressed Ctrl-C. Long work throws this at a point where all files are whole; exit status 130.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted") {}
};

}  // namespace foreview
