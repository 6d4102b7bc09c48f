#include "foreview/gpu/output_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "foreview/scene/errors.h"

namespace foreview {

void write_pieces(const std::filesystem::path& file, std::initializer_list<std::string_view> pieces) {
  errno = 0;
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  for (const std::string_view piece : pieces) {
    stream.write(piece.data(), static_cast<std::streamsize>(piece.size()));
  }
  if (!stream.flush()) {
    const int reason = errno;
    std::error_code ignored;
    std::filesystem::remove(file, ignored);
    throw InputError(file.string(), std::string("cannot be written") +
                                        (reason != 0 ? ": " + std::generic_category().message(reason) : ""));
  }
}

void replace_file(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::error_code error;
  std::filesystem::rename(from, to, error);
  if (!error) return;
  std::error_code ignored;
  std::filesystem::remove(from, ignored);
  throw InputError(to.string(), "cannot be written: " + error.message());
}

}  // namespace foreview
