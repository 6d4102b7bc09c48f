#include "foreview/scene/yaml_input.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <utility>

#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"

namespace foreview {
namespace {

std::string place(const std::string& where, const YAML::Mark& mark) {
  return mark.is_null() ? where : where + ":" + std::to_string(mark.line + 1);
}

}  // namespace

YamlMap::YamlMap(const YAML::Node& node, std::string where, std::string prefix)
    : node_(node), where_(std::move(where)), prefix_(std::move(prefix)) {}

YamlMap YamlMap::parse(const std::string& text, const std::string& where) {
  if (text.size() > kMaxBytes) {
    throw InputError(where, "is larger than the " + std::to_string(kMaxBytes) + " bytes allowed for YAML");
  }
  YAML::Node root;
  try {
    root = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw InputError(place(where, error.mark), "is not valid YAML: " + printable(error.msg));
  } catch (const std::exception& error) {
    throw InputError(where, "is not valid YAML: " + printable(error.what()));
  }
  if (!root.IsDefined() || root.IsNull()) root = YAML::Node(YAML::NodeType::Map);
  if (!root.IsMap()) throw InputError(place(where, root.Mark()), "expected lines 'key: value'");
  return {root, where, ""};
}

void YamlMap::allow_only(std::initializer_list<const char*> keys) const {
  std::set<std::string> seen;
  for (const auto& entry : node_) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "(not a word)";
    bool known = false;
    std::string list;
    for (const char* allowed : keys) {
      known = known || key == allowed;
      if (!list.empty()) list += ", ";
      list += allowed;
    }
    const std::string inside = prefix_.empty() ? "" : " in " + prefix_.substr(0, prefix_.size() - 1);
    const std::string at = place(where_, entry.first.Mark());
    if (!known) throw InputError(at, "unknown key " + in_quotes(key) + inside + "; expected one of: " + list);
    if (!seen.insert(key).second) throw InputError(at, "key " + in_quotes(key) + inside + " is there twice");
  }
}

YAML::Node YamlMap::find(const std::string& key) const {
  // Not node_[key]: yaml-cpp compares converted keys, and throws on maps with keys that are no scalars.
  for (const auto& entry : node_) {
    if (entry.first.IsScalar() && entry.first.Scalar() == key) return entry.second;
  }
  return YAML::Node(YAML::NodeType::Undefined);
}

bool YamlMap::has(const std::string& key) const {
  return find(key).IsDefined();
}

std::string YamlMap::first_of(std::initializer_list<const char*> keys) const {
  for (const char* key : keys) {
    if (has(key)) return key;
  }
  return *keys.begin();
}

void YamlMap::fail_at(const YAML::Node& node, const std::string& key, const std::string& why) const {
  throw InputError(node.IsDefined() ? place(where_, node.Mark()) : where_, prefix_ + key + ": " + why);
}

void YamlMap::fail(const std::string& key, const std::string& why) const {
  fail_at(find(key), key, why);
}

const std::string& YamlMap::scalar(const YAML::Node& node, const std::string& key, const char* wanted) const {
  if (!node.IsScalar()) fail_at(node, key, std::string("expected ") + wanted);
  return node.Scalar();
}

const std::string& YamlMap::plain_text(const YAML::Node& node, const std::string& key, const char* wanted) const {
  const std::string& text = scalar(node, key, wanted);
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  if (std::any_of(text.begin(), text.end(), is_control)) {
    fail_at(node, key, "holds line ends or other control characters; expected " + std::string(wanted));
  }
  return text;
}

std::optional<std::string> YamlMap::text(const std::string& key) const {
  const YAML::Node node = find(key);
  if (!node.IsDefined()) return std::nullopt;
  return plain_text(node, key, "a text");
}

std::optional<bool> YamlMap::flag(const std::string& key) const {
  const YAML::Node node = find(key);
  if (!node.IsDefined()) return std::nullopt;
  const std::string& word = scalar(node, key, "true or false");
  if (word == "true" || word == "yes" || word == "on") return true;
  if (word == "false" || word == "no" || word == "off") return false;
  fail_at(node, key, "expected true or false, not " + in_quotes(word));
}

std::optional<double> YamlMap::number(const std::string& key, double lowest, double highest) const {
  const YAML::Node node = find(key);
  if (!node.IsDefined()) return std::nullopt;
  const std::string& word = scalar(node, key, "a number");
  double value = 0;
  if (!parse_number(word, value)) fail_at(node, key, "expected a number, not " + in_quotes(word));
  if (!(value >= lowest && value <= highest)) {
    fail_at(node, key, "is " + word + "; expected " + number_text(lowest) + " to " + number_text(highest));
  }
  return value;
}

std::optional<int> YamlMap::integer(const std::string& key, int lowest, int highest) const {
  const std::optional<double> value = number(key, lowest, highest);
  if (!value) return std::nullopt;
  if (*value != std::floor(*value)) fail(key, "expected a whole number");
  return static_cast<int>(*value);
}

std::optional<YamlMap> YamlMap::map(const std::string& key) const {
  const YAML::Node node = find(key);
  if (!node.IsDefined()) return std::nullopt;
  if (!node.IsMap()) fail_at(node, key, "expected a map of keys and values");
  return YamlMap(node, where_, prefix_ + key + ".");
}

std::optional<std::vector<std::string>> YamlMap::texts(const std::string& key) const {
  const YAML::Node node = find(key);
  if (!node.IsDefined()) return std::nullopt;
  if (!node.IsSequence()) fail_at(node, key, "expected a list, as in [left, right]");
  std::vector<std::string> result;
  for (const auto& item : node) result.push_back(plain_text(item, key, "a list of words"));
  return result;
}

std::optional<std::vector<double>> YamlMap::matrix(const std::string& key) const {
  constexpr std::size_t kMostNumbers = 64;
  YAML::Node node = find(key);
  if (!node.IsDefined()) return std::nullopt;
  if (node.IsMap()) {
    const YAML::Node data = YamlMap(node, where_, prefix_).find("data");
    if (!data.IsDefined()) fail_at(node, key, "expected 'data' with a list of numbers");
    node.reset(data);
  }
  if (!node.IsSequence()) fail_at(node, key, "expected a list of numbers");
  std::vector<double> result;
  const auto add = [&](const YAML::Node& item) {
    double value = 0;
    const std::string& word = scalar(item, key, "a list of numbers");
    if (!parse_number(word, value)) fail_at(item, key, "expected numbers, not " + in_quotes(word));
    if (!std::isfinite(value)) fail_at(item, key, "holds " + word + "; expected finite numbers");
    if (result.size() == kMostNumbers) fail_at(item, key, "has too many numbers");
    result.push_back(value);
  };
  for (const auto& item : node) {
    if (!item.IsSequence()) {
      add(item);
      continue;
    }
    for (const auto& number : item) add(number);
  }
  return result;
}

std::string yaml_quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      result += '\\';
      result += c;
    } else if (code < 0x20 || code == 0x7f) {
      char escaped[8];
      std::snprintf(escaped, sizeof escaped, "\\x%02x", code);
      result += escaped;
    } else {
      result += c;
    }
  }
  return result + "\"";
}

}  // namespace foreview
