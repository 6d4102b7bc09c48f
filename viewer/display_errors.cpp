#include "foreview/viewer/display_errors.h"

#include <dlfcn.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <exception>
#include <utility>

namespace foreview {
namespace {

// Xlib is there only where GLFW uses it, so it is asked for at run time; these are its declarations, as far as needed.
struct XErrorEvent {
  int type;
  void* display;
  unsigned long resource;
  unsigned long serial;
  unsigned char error_code;
  unsigned char request_code;
  unsigned char minor_code;
};
using ErrorHandler = int (*)(void*, XErrorEvent*);
using IoErrorHandler = int (*)(void*);

constexpr unsigned char kBadWindow = 3, kBadDrawable = 9;
constexpr int kGraphicsError = 3;  // as main.cpp

std::atomic<bool> window_gone{false};
std::function<void()>& lost_action() {
  static std::function<void()> action;
  return action;
}

int on_error(void* /*display*/, XErrorEvent* event) {
  if (event->error_code == kBadWindow || event->error_code == kBadDrawable) window_gone = true;
  return 0;
}

[[noreturn]] void end_without_display() {
  static std::atomic<bool> ending{false};
  if (!ending.exchange(true)) {
    try {
      if (lost_action()) lost_action()();
    } catch (const std::exception& error) {
      std::fprintf(stderr, "foreview: %s\n", error.what());
    }
  }
  std::fputs("foreview: the display server is gone\n", stderr);
  std::fflush(nullptr);
  // Destructors would ask the display to take the window away.
  _exit(kGraphicsError);
}

int on_io_error(void* /*display*/) {
  end_without_display();
}

struct Xlib {
  void* library = dlopen("libX11.so.6", RTLD_LAZY | RTLD_NOLOAD);
  template <class Function>
  [[nodiscard]] Function find(const char* name) const {
    return library != nullptr ? reinterpret_cast<Function>(dlsym(library, name)) : nullptr;
  }
  ErrorHandler (*set_error_handler)(ErrorHandler) = find<ErrorHandler (*)(ErrorHandler)>("XSetErrorHandler");
  IoErrorHandler (*set_io_error_handler)(IoErrorHandler) =
      find<IoErrorHandler (*)(IoErrorHandler)>("XSetIOErrorHandler");
};

}  // namespace

void watch_display() {
  static const Xlib xlib;
  if (xlib.set_error_handler != nullptr) xlib.set_error_handler(on_error);
  if (xlib.set_io_error_handler != nullptr) xlib.set_io_error_handler(on_io_error);
}

bool window_is_gone() {
  return window_gone;
}

void set_display_lost_action(std::function<void()> action) {
  lost_action() = std::move(action);
}

}  // namespace foreview
