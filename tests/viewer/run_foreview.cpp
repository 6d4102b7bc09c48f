#include "viewer/run_foreview.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>
#include <thread>

namespace foreview::test {
namespace {

std::string read_text(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

void redirect(const std::filesystem::path& file, int descriptor) {
  const int opened = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (opened < 0 || dup2(opened, descriptor) < 0) _exit(126);
}

}  // namespace

RunningForeview::RunningForeview(const std::vector<std::string>& arguments,
                                 const std::map<std::string, std::string>& environment) {
  std::string pattern = (std::filesystem::temp_directory_path() / "foreview-run-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("cannot create " + pattern);
  directory_ = pattern;
  std::vector<std::string> texts{FOREVIEW_EXECUTABLE};
  texts.insert(texts.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& text : texts) argv.push_back(text.data());
  argv.push_back(nullptr);
  process_ = fork();
  if (process_ < 0) throw std::runtime_error("cannot start a process");
  if (process_ == 0) {
    redirect(directory_ / "out", STDOUT_FILENO);
    redirect(directory_ / "err", STDERR_FILENO);
    setenv("FOREVIEW_GL_DEBUG", "fatal", 1);
    for (const auto& [name, value] : environment) {
      if (value.empty()) {
        unsetenv(name.c_str());
      } else {
        setenv(name.c_str(), value.c_str(), 1);
      }
    }
    execv(argv[0], argv.data());
    _exit(127);
  }
}

RunningForeview::~RunningForeview() {
  if (!status_) {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  std::error_code ignored;
  std::filesystem::remove_all(directory_, ignored);
}

void RunningForeview::send_signal(int signal) const {
  if (!status_) kill(process_, signal);
}

std::optional<int> RunningForeview::wait(double seconds) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!status_) {
    int raw = 0;
    if (waitpid(process_, &raw, WNOHANG) == process_) {
      status_ = WIFEXITED(raw) ? WEXITSTATUS(raw) : 128 + WTERMSIG(raw);
    } else if (std::chrono::steady_clock::now() > until) {
      break;
    } else {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }
  return status_;
}

std::string RunningForeview::standard_output() const {
  return read_text(directory_ / "out");
}

std::string RunningForeview::standard_error() const {
  return read_text(directory_ / "err");
}

Finished run_foreview(const std::vector<std::string>& arguments,
                      const std::map<std::string, std::string>& environment) {
  RunningForeview running(arguments, environment);
  const int status = running.wait(120).value_or(-1);
  return {status, running.standard_output(), running.standard_error()};
}

}  // namespace foreview::test
