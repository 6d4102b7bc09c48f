#include "foreview/viewer/window.h"

// GLFW must not bring OpenGL headers of its own.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "foreview/gpu/offscreen_context.h"
#include "foreview/scene/errors.h"
#include "foreview/viewer/gl_debug.h"

namespace foreview {
namespace {

constexpr const char* kAdvice = "; without a display use --headless --out DIR";

std::string glfw_error() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text != nullptr ? text : "unknown reason";
}

int special_key(int key) {
  switch (key) {
    case GLFW_KEY_TAB:
      return KeyChord::tab;
    case GLFW_KEY_SPACE:
      return KeyChord::space;
    case GLFW_KEY_ESCAPE:
      return KeyChord::escape;
    case GLFW_KEY_ENTER:
    case GLFW_KEY_KP_ENTER:
      return KeyChord::enter;
    case GLFW_KEY_LEFT:
      return KeyChord::left;
    case GLFW_KEY_RIGHT:
      return KeyChord::right;
    case GLFW_KEY_UP:
      return KeyChord::up;
    case GLFW_KEY_DOWN:
      return KeyChord::down;
    case GLFW_KEY_HOME:
      return KeyChord::home;
    case GLFW_KEY_END:
      return KeyChord::end;
    case GLFW_KEY_PAGE_UP:
      return KeyChord::page_up;
    case GLFW_KEY_PAGE_DOWN:
      return KeyChord::page_down;
    default:
      return key >= GLFW_KEY_F1 && key <= GLFW_KEY_F12 ? KeyChord::f1 + key - GLFW_KEY_F1 : 0;
  }
}

/// The character on the key; where that is none of ASCII's (brackets on many layouts), what an American keyboard has
/// there.
int printable_key(int key, int scancode) {
  const char* name = glfwGetKeyName(key, scancode);
  const bool ascii = name != nullptr && name[0] > ' ' && name[0] <= '~' && name[1] == '\0';
  if (ascii) return std::tolower(static_cast<unsigned char>(name[0]));
  return key > ' ' && key <= '~' ? std::tolower(key) : 0;
}

void limit_to_monitor(int& width, int& height) {
  GLFWmonitor* monitor = glfwGetPrimaryMonitor();
  if (monitor == nullptr) return;
  int x = 0, y = 0, most_width = width, most_height = height;
  glfwGetMonitorWorkarea(monitor, &x, &y, &most_width, &most_height);
  const double scale =
      std::min({1.0, static_cast<double>(most_width) / width, static_cast<double>(most_height) / height});
  width = std::max(static_cast<int>(width * scale), 1);
  height = std::max(static_cast<int>(height * scale), 1);
}

}  // namespace

Window::Window(const std::string& title, int width, int height) : title_(title) {
  if (glfwInit() == GLFW_FALSE) throw GraphicsError("no window: " + glfw_error() + kAdvice);
  const GlDebug debug = gl_debug_from_environment();
  glfwWindowHint(GLFW_CLIENT_API, GLFW_OPENGL_API);
  // Off-screen contexts are made through EGL too and can then share objects with the window's.
  glfwWindowHint(GLFW_CONTEXT_CREATION_API, GLFW_EGL_CONTEXT_API);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, debug != GlDebug::off ? GLFW_TRUE : GLFW_FALSE);
  // Frames come whole from off-screen targets: the window itself needs neither depth nor samples.
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  limit_to_monitor(width, height);
  window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
  if (window_ == nullptr) {
    const std::string why = glfw_error();
    glfwTerminate();
    throw GraphicsError("no window with OpenGL 4.5: " + why + kAdvice);
  }
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  if (debug != GlDebug::off) install_debug_callback(debug == GlDebug::fatal);
  set_up_context_state();
  glfwSetWindowUserPointer(window_, this);
  glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int scancode, int action, int modifiers) {
    static_cast<Window*>(glfwGetWindowUserPointer(window))->on_key(key, scancode, action, modifiers);
  });
  glfwSetFramebufferSizeCallback(window_, [](GLFWwindow* window, int new_width, int new_height) {
    auto* self = static_cast<Window*>(glfwGetWindowUserPointer(window));
    self->width_ = new_width;
    self->height_ = new_height;
  });
  glfwGetFramebufferSize(window_, &width_, &height_);
}

Window::~Window() {
  glfwDestroyWindow(window_);
  glfwTerminate();
}

void Window::on_key(int key, int scancode, int action, int modifiers) {
  if (action == GLFW_RELEASE) return;
  KeyChord chord;
  chord.key = special_key(key);
  if (chord.key == 0) chord.key = printable_key(key, scancode);
  if (chord.key == 0) return;
  chord.shift = (modifiers & GLFW_MOD_SHIFT) != 0;
  chord.control = (modifiers & GLFW_MOD_CONTROL) != 0;
  keys_.push_back({chord, action == GLFW_REPEAT});
}

void Window::poll_events(double wait_seconds) {
  if (wait_seconds > 0) {
    glfwWaitEventsTimeout(wait_seconds);
  } else {
    glfwPollEvents();
  }
}

std::vector<Window::Key> Window::take_keys() {
  return std::exchange(keys_, {});
}

bool Window::close_requested() const {
  return glfwWindowShouldClose(window_) == GLFW_TRUE;
}

void Window::resize(int width, int height) {
  limit_to_monitor(width, height);
  glfwSetWindowSize(window_, width, height);
}

void Window::set_title(const std::string& title) {
  if (title == title_) return;
  title_ = title;
  glfwSetWindowTitle(window_, title.c_str());
}

void Window::present(GLuint framebuffer, int frame_width, int frame_height) {
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glClearColor(0, 0, 0, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  const int x = (width_ - frame_width) / 2, y = (height_ - frame_height) / 2;
  // Row 0 of the frame is its top, row 0 of the window its bottom.
  glBlitNamedFramebuffer(framebuffer, 0, 0, 0, frame_width, frame_height, x, y + frame_height, x + frame_width, y,
                         GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glfwSwapBuffers(window_);
}

}  // namespace foreview
