#include "foreview/scene/input_file.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <system_error>

#include "foreview/scene/errors.h"

namespace foreview {

std::string read_input_file(const std::filesystem::path& file, std::size_t max_bytes) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (status.type() == std::filesystem::file_type::not_found) throw InputError(file.string(), "no such file");
  if (error) throw InputError(file.string(), "cannot be read: " + error.message());
  if (status.type() == std::filesystem::file_type::directory) {
    throw InputError(file.string(), "is a directory; expected a file");
  }
  if (status.type() != std::filesystem::file_type::regular) {
    throw InputError(file.string(), "is a pipe or a device; expected a file");
  }
  const auto too_large = [&] {
    return InputError(file.string(), "is larger than the " + std::to_string(max_bytes) + " bytes allowed here");
  };
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) throw InputError(file.string(), "cannot be read: " + error.message());
  if (size > max_bytes) throw too_large();

  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(file.string(), "cannot be opened for reading");
  std::string bytes(static_cast<std::size_t>(size), '\0');
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (stream.bad()) throw InputError(file.string(), "cannot be read to its end");
  bytes.resize(static_cast<std::size_t>(stream.gcount()));
  return bytes;
}

std::string printable(std::string_view text) {
  constexpr std::size_t kLongest = 100;
  std::string result;
  for (const char c : text.substr(0, kLongest)) {
    const auto code = static_cast<unsigned char>(c);
    result += code < 0x20 || code >= 0x7f ? '?' : c;
  }
  if (text.size() > kLongest) result += "...";
  return result;
}

std::string in_quotes(std::string_view text) {
  return "'" + printable(text) + "'";
}

bool parse_number(std::string_view text, double& result) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double value = 0;
  const char* const stop = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), stop, value);
  if (error != std::errc() || end != stop) return false;
  result = value;
  return true;
}

std::string number_text(double value) {
  char text[40];
  const auto [end, error] = std::to_chars(text, text + sizeof text, value);
  return {text, end};
}

}  // namespace foreview
