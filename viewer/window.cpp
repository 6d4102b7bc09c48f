#include "foreview/viewer/window.h"

// GLFW must not bring OpenGL headers of its own.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#define GLFW_EXPOSE_NATIVE_EGL
#include <GLFW/glfw3native.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "foreview/gpu/offscreen_context.h"
#include "foreview/viewer/display_errors.h"
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
  width = std::clamp(width, 1, std::max(most_width, 1));
  height = std::clamp(height, 1, std::max(most_height, 1));
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
  // Told of the GPU's resets, where the driver can tell.
  for (const int robustness : {GLFW_LOSE_CONTEXT_ON_RESET, GLFW_NO_ROBUSTNESS}) {
    glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, robustness);
    window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
    if (window_ != nullptr) break;
  }
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
  glfwSetWindowSizeCallback(window_, [](GLFWwindow* window, int points, int) {
    static_cast<Window*>(glfwGetWindowUserPointer(window))->points_ = points;
  });
  glfwSetFramebufferSizeCallback(window_, [](GLFWwindow* window, int new_width, int new_height) {
    auto* self = static_cast<Window*>(glfwGetWindowUserPointer(window));
    self->width_ = new_width;
    self->height_ = new_height;
  });
  glfwSetWindowContentScaleCallback(window_, [](GLFWwindow* window, float x_scale, float) {
    static_cast<Window*>(glfwGetWindowUserPointer(window))->content_scale_ = x_scale;
  });
  glfwGetFramebufferSize(window_, &width_, &height_);
  int points_high = 0;
  glfwGetWindowSize(window_, &points_, &points_high);
  float y_scale = 1;
  glfwGetWindowContentScale(window_, &content_scale_, &y_scale);
  watch_display();
}

Window::~Window() {
  glfwDestroyWindow(window_);
  glfwTerminate();
}

void Window::check_alive() const {
  if (window_is_gone()) throw WindowLost("the window was destroyed by another program");
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
  check_alive();
  if (wait_seconds > 0) {
    glfwWaitEventsTimeout(wait_seconds);
  } else {
    glfwPollEvents();
  }
  watch_display();
  check_alive();
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

std::bitset<kMoveKeys> Window::held_moves() const {
  constexpr std::array kKeys{
      std::pair{GLFW_KEY_LEFT, KeyChord::left},       std::pair{GLFW_KEY_RIGHT, KeyChord::right},
      std::pair{GLFW_KEY_UP, KeyChord::up},           std::pair{GLFW_KEY_DOWN, KeyChord::down},
      std::pair{GLFW_KEY_PAGE_UP, KeyChord::page_up}, std::pair{GLFW_KEY_PAGE_DOWN, KeyChord::page_down},
  };
  const auto down = [&](int key) { return glfwGetKey(window_, key) == GLFW_PRESS; };
  const bool shift = down(GLFW_KEY_LEFT_SHIFT) || down(GLFW_KEY_RIGHT_SHIFT);
  const bool control = down(GLFW_KEY_LEFT_CONTROL) || down(GLFW_KEY_RIGHT_CONTROL);
  std::bitset<kMoveKeys> moves;
  for (const auto& [key, special] : kKeys) {
    if (!down(key)) continue;
    if (const auto move = move_of({special, shift, control})) moves.set(static_cast<std::size_t>(*move));
  }
  return moves;
}

void Window::set_full_screen(bool on) {
  if (on == full_screen_) return;
  GLFWmonitor* monitor = glfwGetPrimaryMonitor();
  const GLFWvidmode* mode = monitor != nullptr ? glfwGetVideoMode(monitor) : nullptr;
  if (mode == nullptr) return;
  full_screen_ = on;
  Area& before = before_full_screen_;
  if (on) {
    glfwGetWindowPos(window_, &before.x, &before.y);
    glfwGetWindowSize(window_, &before.width, &before.height);
    glfwSetWindowMonitor(window_, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
  } else {
    glfwSetWindowMonitor(window_, nullptr, before.x, before.y, before.width, before.height, 0);
  }
}

void Window::copy_to_clipboard(const std::string& text) {
  glfwSetClipboardString(window_, text.c_str());
}

bool Window::minimised() const {
  return width_ < 1 || height_ < 1 || glfwGetWindowAttrib(window_, GLFW_ICONIFIED) == GLFW_TRUE;
}

int Window::refresh_rate() const {
  GLFWmonitor* monitor = glfwGetPrimaryMonitor();
  const GLFWvidmode* mode = monitor != nullptr ? glfwGetVideoMode(monitor) : nullptr;
  return mode != nullptr ? mode->refreshRate : 0;
}

void Window::make_current() {
  glfwMakeContextCurrent(window_);
}

void* Window::egl_display() const {
  return glfwGetEGLDisplay();
}

void* Window::egl_context() const {
  return glfwGetEGLContext(window_);
}

void Window::draw(GLuint framebuffer, int frame_width, int frame_height, const Area& area) {
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glViewport(0, 0, width_, height_);
  glClearColor(0, 0, 0, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  const int x = area.x + (area.width - frame_width) / 2;
  const int top = height_ - area.y - (area.height - frame_height) / 2;
  // Row 0 of the frame is its top, row 0 of the window its bottom.
  glBlitNamedFramebuffer(framebuffer, 0, 0, 0, frame_width, frame_height, x, top, x + frame_width, top - frame_height,
                         GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

void Window::set_swap_interval(int frames) {
  glfwSwapInterval(frames);
}

void Window::swap() {
  glfwSwapBuffers(window_);
  check_alive();
}

}  // namespace foreview
