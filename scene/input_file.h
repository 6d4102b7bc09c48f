#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace foreview {

/// The bytes of a regular file. Throws InputError naming the file where it is missing, a directory, a pipe or a device
/// (opening those could wait for ever), unreadable, or larger than `max_bytes`.
[[nodiscard]] std::string read_input_file(const std::filesystem::path& file, std::size_t max_bytes);

/// Text from outside as it may stand in a one-line message: shortened, whatever is not printable ASCII as '?'.
[[nodiscard]] std::string printable(std::string_view text);
/// The same in quotes.
[[nodiscard]] std::string in_quotes(std::string_view text);

/// A number as a person writes it, independent of the locale: all of `text`, decimal, with or without exponent; "nan"
/// and "inf" are read too. Returns false, and leaves `result` alone, on anything else.
[[nodiscard]] bool parse_number(std::string_view text, double& result);

/// The shortest decimal text that parse_number reads back to the same double.
[[nodiscard]] std::string number_text(double value);

}  // namespace foreview
