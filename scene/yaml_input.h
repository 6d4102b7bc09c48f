#pragma once
#include <yaml-cpp/node/node.h>

#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

namespace foreview {

/// A map of a YAML file from outside, read strictly: every error is an InputError "FILE:LINE: KEY: why". Only what is
/// asked for is looked at, so aliases that expand to billions of nodes cost nothing.
class YamlMap {
 public:
  static constexpr std::size_t kMaxBytes = 64 * 1024;

  /// Parses a document whose root is a map; an empty document is an empty map. `where` names the source.
  [[nodiscard]] static YamlMap parse(const std::string& text, const std::string& where);

  /// Throws where a key is not among `keys`, not a scalar, or there twice.
  void allow_only(std::initializer_list<const char*> keys) const;
  [[nodiscard]] bool has(const std::string& key) const;
  /// The first of these keys that is there, else the first of all: for files whose writers disagree about names.
  [[nodiscard]] std::string first_of(std::initializer_list<const char*> keys) const;

  // Each returns nothing where the key is absent, and throws where its value is of another kind.
  /// Without control characters.
  [[nodiscard]] std::optional<std::string> text(const std::string& key) const;
  [[nodiscard]] std::optional<bool> flag(const std::string& key) const;
  /// Finite and within [lowest, highest].
  [[nodiscard]] std::optional<double> number(const std::string& key, double lowest, double highest) const;
  [[nodiscard]] std::optional<int> integer(const std::string& key, int lowest, int highest) const;
  [[nodiscard]] std::optional<YamlMap> map(const std::string& key) const;
  [[nodiscard]] std::optional<std::vector<std::string>> texts(const std::string& key) const;
  /// A matrix as ROS and OpenCV write it: a map with `data`, a plain list, or a list of rows. Finite numbers, at most
  /// 64 of them.
  [[nodiscard]] std::optional<std::vector<double>> matrix(const std::string& key) const;

  /// Throws the InputError of this key.
  [[noreturn]] void fail(const std::string& key, const std::string& why) const;

 private:
  YamlMap(const YAML::Node& node, std::string where, std::string prefix);
  [[nodiscard]] YAML::Node find(const std::string& key) const;
  [[nodiscard]] const std::string& scalar(const YAML::Node& node, const std::string& key, const char* wanted) const;
  [[nodiscard]] const std::string& plain_text(const YAML::Node& node, const std::string& key, const char* wanted) const;
  [[noreturn]] void fail_at(const YAML::Node& node, const std::string& key, const std::string& why) const;

  YAML::Node node_;
  std::string where_, prefix_;
};

/// Text as a double-quoted YAML scalar.
[[nodiscard]] std::string yaml_quoted(const std::string& text);

}  // namespace foreview
