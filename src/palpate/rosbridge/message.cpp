#include <palpate/rosbridge/message.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include <fmt/format.h>

namespace palpate {
namespace {

constexpr std::size_t kLongestText = 1 << 16;

/// Checks CBOR without recursion, and rejects what it does not support: the recursive parser may then read
/// it.
class CborWalk {
 public:
  explicit CborWalk(std::string_view bytes) : rest_(bytes) {}

  void check() {
    open_ = {1};
    while (!open_.empty()) {
      if (open_.back() == 0) {
        open_.pop_back();
        continue;
      }
      --open_.back();
      item();
    }
    if (!rest_.empty()) throw Refusal("CBOR: data after the message");
  }

 private:
  void item() {
    const auto head = static_cast<unsigned char>(take(1)[0]);
    const unsigned major = head >> 5U, minor = head & 31U;
    if (major == 7) {  // simple values and floats; no break
      if (minor > 27) throw Refusal("CBOR: malformed, or of indefinite length, which is not supported");
      if (minor >= 24) take(std::size_t{1} << (minor - 24));
      return;
    }
    const std::uint64_t n = argument(minor);
    switch (major) {
      case 0:
      case 1: return;
      case 2:
      case 3: take(n); return;
      case 4: open(n); return;
      case 5:
        if (n > rest_.size())
          throw Refusal("CBOR: the message is truncated");  // so that 2 * n does not overflow
        open(2 * n);
        return;
      default: throw Refusal("CBOR: tags are not supported");
    }
  }

  void open(std::uint64_t items) {
    if (items > rest_.size()) throw Refusal("CBOR: the message is truncated");
    if (open_.size() > kMostLevels)
      throw Refusal(fmt::format("CBOR: nested more than {} levels deep", kMostLevels));
    open_.push_back(items);
  }

  std::uint64_t argument(unsigned minor) {
    if (minor < 24) return minor;
    if (minor > 27) throw Refusal("CBOR: malformed, or of indefinite length, which is not supported");
    std::uint64_t value = 0;
    for (const char byte : take(std::size_t{1} << (minor - 24)))
      value = value << 8U | static_cast<unsigned char>(byte);
    return value;
  }

  std::string_view take(std::uint64_t n) {
    if (n > rest_.size()) throw Refusal("CBOR: the message is truncated");
    const std::string_view taken = rest_.substr(0, n);
    rest_.remove_prefix(n);
    return taken;
  }

  std::string_view rest_;
  std::vector<std::uint64_t> open_;  ///< remaining items of each level
};

}  // namespace

std::string encode_json(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json decode_json(std::string_view text) {
  const auto levels = [](int depth, Json::parse_event_t event, Json&) {
    // At the beginning of an array or object, the depth is still that of the enclosing one.
    const bool begins =
        event == Json::parse_event_t::object_start || event == Json::parse_event_t::array_start;
    if (depth + (begins ? 1 : 0) > static_cast<int>(kMostLevels))
      throw Refusal(fmt::format("JSON: nested more than {} levels deep", kMostLevels));
    return true;
  };
  if (text.find('\0') != std::string_view::npos)
    throw Refusal("the message is not valid JSON");  // the parser stops there
  try {
    return Json::parse(text.begin(), text.end(), levels);
  } catch (const Json::exception&) {
    throw Refusal("the message is not valid JSON");
  }
}

Json decode_cbor(std::string_view bytes) {
  CborWalk(bytes).check();
  try {
    return Json::from_cbor(bytes.begin(), bytes.end());
  } catch (const Json::exception&) {
    throw Refusal("the message is not valid CBOR");
  }
}

std::string text_field(const Json& message, const char* name) {
  const auto at = message.find(name);
  if (at == message.end() || at->is_null()) return {};
  if (!at->is_string()) throw Refusal(fmt::format("'{}' must be text", name));
  const auto& text = at->get_ref<const std::string&>();
  if (text.size() > kLongestText)
    throw Refusal(fmt::format("'{}' is longer than {} bytes", name, kLongestText));
  return text;
}

double number_field(const Json& message, const char* name, double missing) {
  const auto at = message.find(name);
  if (at == message.end()) return missing;
  const double value = at->is_number() ? at->get<double>() : std::nan("");
  if (!std::isfinite(value)) throw Refusal(fmt::format("'{}' must be a finite number", name));
  return value;
}

const Json& field(const Json& message, const char* name) {
  const auto at = message.find(name);
  if (at == message.end()) throw Refusal(fmt::format("'{}' is missing", name));
  return *at;
}

}  // namespace palpate
