#pragma once
#include <sys/types.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace foreview::test {

/// The executable, running as a child process with its output kept in files.
class RunningForeview {
 public:
  /// `environment` is added to the test's own; an empty value removes the variable. OpenGL errors are always fatal.
  explicit RunningForeview(const std::vector<std::string>& arguments,
                           const std::map<std::string, std::string>& environment = {});
  /// Kills the process if it is still running.
  ~RunningForeview();
  RunningForeview(const RunningForeview&) = delete;
  RunningForeview& operator=(const RunningForeview&) = delete;

  void send_signal(int signal) const;
  /// Exit status, 128 + signal where one ended it, or none if it is still running after so many seconds.
  std::optional<int> wait(double seconds);
  [[nodiscard]] std::string standard_output() const;
  [[nodiscard]] std::string standard_error() const;

 private:
  std::filesystem::path directory_;
  pid_t process_ = -1;
  std::optional<int> status_;
};

struct Finished {
  int status = -1;  ///< -1: it did not end within two minutes
  std::string out, err;
};
/// Runs foreview to its end.
[[nodiscard]] Finished run_foreview(const std::vector<std::string>& arguments,
                                    const std::map<std::string, std::string>& environment = {});

}  // namespace foreview::test
