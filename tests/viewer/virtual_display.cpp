#include "viewer/virtual_display.h"

#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <vector>

namespace foreview::test {
namespace {

/// Windows may go while they are looked at; X reports that as errors, which would end the process.
int ignore_error(Display*, XErrorEvent*) {
  return 0;
}

std::string title_of(Display* display, Window window) {
  char* text = nullptr;
  std::string title;
  if (XFetchName(display, window, &text) != 0 && text != nullptr) title = text;
  if (text != nullptr) XFree(text);
  return title;
}

Window find_window(Display* display, const std::string& beginning) {
  Window root = 0, parent = 0, *children = nullptr, found = 0;
  unsigned count = 0;
  if (XQueryTree(display, DefaultRootWindow(display), &root, &parent, &children, &count) == 0) return 0;
  for (unsigned i = 0; i < count && found == 0; ++i) {
    if (title_of(display, children[i]).rfind(beginning, 0) == 0) found = children[i];
  }
  if (children != nullptr) XFree(children);
  return found;
}

}  // namespace

struct VirtualDisplay::Connection {
  Display* display = nullptr;
};

bool VirtualDisplay::installed() {
  const char* path = std::getenv("PATH");
  std::istringstream directories(path != nullptr ? path : "");
  std::string directory;
  while (std::getline(directories, directory, ':')) {
    if (access((directory + "/Xvfb").c_str(), X_OK) == 0) return true;
  }
  return false;
}

VirtualDisplay::VirtualDisplay(int width, int height) {
  int channel[2] = {-1, -1};
  if (pipe(channel) != 0) throw std::runtime_error("cannot make a pipe");
  const std::string screen = std::to_string(width) + "x" + std::to_string(height) + "x24";
  const std::string descriptor = std::to_string(channel[1]);
  server_ = fork();
  if (server_ == 0) {
    ::close(channel[0]);
    execlp("Xvfb", "Xvfb", "-displayfd", descriptor.c_str(), "-screen", "0", screen.c_str(), "-nolisten", "tcp",
           "-noreset", static_cast<char*>(nullptr));
    _exit(127);
  }
  ::close(channel[1]);
  // The server writes its number when it is ready.
  std::string number;
  pollfd waiting{channel[0], POLLIN, 0};
  while (number.find('\n') == std::string::npos && poll(&waiting, 1, 20'000) > 0) {
    char text[16];
    const ssize_t got = read(channel[0], text, sizeof text);
    if (got <= 0) break;
    number.append(text, static_cast<std::size_t>(got));
  }
  ::close(channel[0]);
  if (number.find('\n') != std::string::npos) {
    name_ = ":" + number.substr(0, number.find('\n'));
    connection_ = new Connection{XOpenDisplay(name_.c_str())};
    XSetErrorHandler(ignore_error);
  }
  if (connection_ == nullptr || connection_->display == nullptr) {
    delete connection_;
    kill(server_, SIGKILL);
    waitpid(server_, nullptr, 0);
    throw std::runtime_error("Xvfb did not start, or cannot be reached");
  }
}

VirtualDisplay::~VirtualDisplay() {
  if (connection_->display != nullptr) XCloseDisplay(connection_->display);
  delete connection_;
  kill(server_, SIGTERM);
  waitpid(server_, nullptr, 0);
}

std::optional<std::string> VirtualDisplay::title(const std::string& beginning) const {
  const Window window = find_window(connection_->display, beginning);
  if (window == 0) return std::nullopt;
  return title_of(connection_->display, window);
}

std::string VirtualDisplay::wait_for_title(const std::string& beginning, const std::string& part,
                                           double seconds) const {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  std::string last;
  while (std::chrono::steady_clock::now() < until) {
    last = title(beginning).value_or("");
    if (!last.empty() && last.find(part) != std::string::npos) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return last;
}

void VirtualDisplay::press(const std::string& beginning, const std::string& key, unsigned modifiers) const {
  Display* display = connection_->display;
  XKeyEvent event{};
  event.display = display;
  event.window = find_window(display, beginning);
  if (event.window == 0) return;
  event.root = DefaultRootWindow(display);
  event.same_screen = True;
  event.state = modifiers;
  event.keycode = XKeysymToKeycode(display, XStringToKeysym(key.c_str()));
  for (const int type : {KeyPress, KeyRelease}) {
    event.type = type;
    XSendEvent(display, event.window, True, type == KeyPress ? KeyPressMask : KeyReleaseMask,
               reinterpret_cast<XEvent*>(&event));
    XSync(display, False);
    // As long as a finger takes at least: widgets look at keys once a frame.
    if (type == KeyPress) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

void VirtualDisplay::resize(const std::string& beginning, int width, int height) const {
  const Window window = find_window(connection_->display, beginning);
  if (window != 0) {
    XResizeWindow(connection_->display, window, static_cast<unsigned>(width), static_cast<unsigned>(height));
  }
  XSync(connection_->display, False);
}

cv::Mat VirtualDisplay::screenshot(const std::string& beginning) const {
  Display* display = connection_->display;
  const Window window = find_window(display, beginning);
  XWindowAttributes attributes;
  if (window == 0 || XGetWindowAttributes(display, window, &attributes) == 0) return {};
  XImage* image = XGetImage(display, window, 0, 0, static_cast<unsigned>(attributes.width),
                            static_cast<unsigned>(attributes.height), AllPlanes, ZPixmap);
  if (image == nullptr) return {};
  cv::Mat picture(image->height, image->width, CV_8UC3);
  for (int y = 0; y < image->height; ++y) {
    for (int x = 0; x < image->width; ++x) {
      const unsigned long value = XGetPixel(image, x, y);
      picture.at<cv::Vec3b>(y, x) = {static_cast<std::uint8_t>(value & 255U),
                                     static_cast<std::uint8_t>(value >> 8U & 255U),
                                     static_cast<std::uint8_t>(value >> 16U & 255U)};
    }
  }
  XDestroyImage(image);
  return picture;
}

void VirtualDisplay::close(const std::string& beginning) const {
  Display* display = connection_->display;
  XEvent event{};
  event.xclient.type = ClientMessage;
  event.xclient.window = find_window(display, beginning);
  if (event.xclient.window == 0) return;
  event.xclient.message_type = XInternAtom(display, "WM_PROTOCOLS", False);
  event.xclient.format = 32;
  event.xclient.data.l[0] = static_cast<long>(XInternAtom(display, "WM_DELETE_WINDOW", False));
  XSendEvent(display, event.xclient.window, False, NoEventMask, &event);
  XSync(display, False);
}

void VirtualDisplay::move_mouse(const std::string& beginning, int x, int y) const {
  const Window window = find_window(connection_->display, beginning);
  if (window != 0) XWarpPointer(connection_->display, None, window, 0, 0, 0, 0, x, y);
  XSync(connection_->display, False);
}

void VirtualDisplay::mouse_button(const std::string& beginning, int button, bool down) const {
  Display* display = connection_->display;
  XButtonEvent event{};
  event.type = down ? ButtonPress : ButtonRelease;
  event.display = display;
  event.window = find_window(display, beginning);
  if (event.window == 0) return;
  event.root = DefaultRootWindow(display);
  event.same_screen = True;
  event.button = static_cast<unsigned>(button);
  Window root = 0, child = 0;
  XQueryPointer(display, event.window, &root, &child, &event.x_root, &event.y_root, &event.x, &event.y, &event.state);
  XSendEvent(display, event.window, True, down ? ButtonPressMask : ButtonReleaseMask,
             reinterpret_cast<XEvent*>(&event));
  XSync(display, False);
}

void VirtualDisplay::drag_mouse(const std::string& beginning, int button, cv::Point from, cv::Point to) const {
  const auto pause = [] { std::this_thread::sleep_for(std::chrono::milliseconds(120)); };
  move_mouse(beginning, from.x, from.y);
  pause();
  mouse_button(beginning, button, true);
  pause();
  constexpr int kSteps = 4;
  for (int i = 1; i <= kSteps; ++i) {
    const cv::Point at = from + (to - from) * i / kSteps;
    move_mouse(beginning, at.x, at.y);
    pause();
  }
  mouse_button(beginning, button, false);
  pause();
}

void VirtualDisplay::set_minimised(const std::string& beginning, bool minimised) const {
  Display* display = connection_->display;
  const Window window = find_window(display, beginning);
  if (window == 0) return;
  const Atom property = XInternAtom(display, "WM_STATE", False);
  const long state[2] = {minimised ? IconicState : NormalState, None};
  XChangeProperty(display, window, property, property, 32, PropModeReplace,
                  reinterpret_cast<const unsigned char*>(state), 2);
  if (minimised) {
    XUnmapWindow(display, window);
  } else {
    XMapWindow(display, window);
  }
  XSync(display, False);
}

void VirtualDisplay::destroy_window(const std::string& beginning) const {
  const Window window = find_window(connection_->display, beginning);
  if (window != 0) XDestroyWindow(connection_->display, window);
  XSync(connection_->display, False);
}

void VirtualDisplay::set_dots_per_inch(int dots) const {
  Display* display = connection_->display;
  const std::string resources = "Xft.dpi:\t" + std::to_string(dots) + "\n";
  XChangeProperty(display, DefaultRootWindow(display), XInternAtom(display, "RESOURCE_MANAGER", False),
                  XInternAtom(display, "STRING", False), 8, PropModeReplace,
                  reinterpret_cast<const unsigned char*>(resources.data()), static_cast<int>(resources.size()));
  XSync(display, False);
}

void VirtualDisplay::kill_server() {
  XCloseDisplay(connection_->display);
  connection_->display = nullptr;
  kill(server_, SIGKILL);
}

}  // namespace foreview::test
