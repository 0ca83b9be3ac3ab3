// JSON, read in C++: in certificates without fractions.
#pragma once

#include "basics.hpp"

struct Json {
  enum Kind { null, boolean, number, text, list, object } kind = null;
  bool truth = false;
  Int value = 0;
  std::string string;
  std::vector<Json> items;
  std::map<std::string, Json> members;

  const Json& at(const std::string& key) const { return members.at(key); }
};

class Parser {
 public:
  explicit Parser(const std::string& text, bool fractions = false) : text_(text), fractions_(fractions) {}
  Json whole() {
    Json found = value(0);
    space();
    require(at_ == text_.size(), "something behind the document");
    return found;
  }

 private:
  void space() { while (at_ < text_.size() && std::string(" \t\r\n").find(text_[at_]) != std::string::npos) ++at_; }
  char peek() { space(); require(at_ < text_.size(), "a document that ends too early"); return text_[at_]; }
  void word(const std::string& expected) {
    require(text_.compare(at_, expected.size(), expected) == 0, "no JSON");
    at_ += expected.size();
  }
  Json value(int depth) {
    require(depth < 2000, "JSON that is nested too deep");
    Json made;
    const char first = peek();
    if (first == '{') {
      made.kind = Json::object;
      ++at_;
      if (peek() == '}') { ++at_; return made; }
      do {
        require(peek() == '"', "an object without a key");
        std::string key = string();
        require(peek() == ':', "a key without a value");
        ++at_;
        require(made.members.emplace(std::move(key), value(depth + 1)).second, "a key twice");
      } while (more('}'));
    } else if (first == '[') {
      made.kind = Json::list;
      ++at_;
      if (peek() == ']') { ++at_; return made; }
      do made.items.push_back(value(depth + 1)); while (more(']'));
    } else if (first == '"') {
      made.kind = Json::text;
      made.string = string();
    } else if (first == 't' || first == 'f') {
      made.kind = Json::boolean;
      made.truth = first == 't';
      word(made.truth ? "true" : "false");
    } else if (first == 'n') {
      word("null");
    } else {
      made.kind = Json::number;
      const std::size_t begin = at_;
      if (first == '-') ++at_;
      const std::size_t digits = at_;
      while (at_ < text_.size() && text_[at_] >= '0' && text_[at_] <= '9') ++at_;
      require(at_ > digits && (text_[digits] != '0' || at_ == digits + 1), "no JSON");
      if (fractions_ && at_ < text_.size() && std::string(".eE").find(text_[at_]) != std::string::npos) {
        while (at_ < text_.size() && std::string("+-.eE0123456789").find(text_[at_]) != std::string::npos) ++at_;
        made.value = std::numeric_limits<Int>::min();  // no number of anything
        return made;
      }
      require(at_ == text_.size() || std::string(".eE").find(text_[at_]) == std::string::npos, "a fraction or an exponent");
      require(at_ - begin <= 18, "a number of more than 18 characters");
      made.value = std::stoll(text_.substr(begin, at_ - begin));
    }
    return made;
  }
  bool more(char end) {
    const char next = peek();
    ++at_;
    require(next == ',' || next == end, "no JSON");
    return next == ',';
  }
  std::uint32_t hex() {
    require(at_ + 4 <= text_.size(), "a document that ends too early");
    std::uint32_t code = 0;
    for (int i = 0; i < 4; ++i) {
      const char digit = text_[at_++];
      require(std::isxdigit(static_cast<unsigned char>(digit)) != 0, "no JSON");
      code = code * 16 + std::uint32_t(digit <= '9' ? digit - '0' : (digit | 32) - 'a' + 10);
    }
    return code;
  }
  static void put(std::string& to, std::uint32_t code) {
    if (code < 0x80) to += char(code);
    else if (code < 0x800) { to += char(0xC0 | code >> 6); to += char(0x80 | (code & 63)); }
    else if (code < 0x10000) { to += char(0xE0 | code >> 12); to += char(0x80 | (code >> 6 & 63)); to += char(0x80 | (code & 63)); }
    else { to += char(0xF0 | code >> 18); to += char(0x80 | (code >> 12 & 63)); to += char(0x80 | (code >> 6 & 63)); to += char(0x80 | (code & 63)); }
  }
  std::string string() {
    std::string made;
    for (++at_;;) {
      require(at_ < text_.size(), "a document that ends too early");
      const char next = text_[at_++];
      if (next == '"') return made;
      require(static_cast<unsigned char>(next) >= 32, "a control character in a text");
      if (next != '\\') { made += next; continue; }
      require(at_ < text_.size(), "a document that ends too early");
      const char escaped = text_[at_++];
      static const std::string from = "\"\\/bfnrt", to = "\"\\/\b\f\n\r\t";
      if (escaped == 'u') {
        std::uint32_t code = hex();
        if (code >= 0xD800 && code < 0xDC00 && text_.compare(at_, 2, "\\u") == 0) {
          at_ += 2;
          const std::uint32_t low = hex();
          require(low >= 0xDC00 && low < 0xE000, "half a character");
          code = 0x10000 + ((code - 0xD800) << 10) + (low - 0xDC00);
        }
        put(made, code);
      } else {
        const std::size_t which = from.find(escaped);
        require(which != std::string::npos, "no JSON");
        made += to[which];
      }
    }
  }

  const std::string& text_;
  bool fractions_;
  std::size_t at_ = 0;
};

inline void check_utf8(const std::string& text) {
  for (std::size_t at = 0; at < text.size();) {
    const auto byte = static_cast<unsigned char>(text[at]);
    const int more = byte < 0x80 ? 0 : byte >> 5 == 6 ? 1 : byte >> 4 == 14 ? 2 : byte >> 3 == 30 ? 3 : -1;
    require(more >= 0 && at + std::size_t(more) < text.size(), "no UTF-8");
    std::uint32_t code = more ? byte & (0x3Fu >> more) : byte;
    for (int i = 1; i <= more; ++i) {
      const auto next = static_cast<unsigned char>(text[at + std::size_t(i)]);
      require(next >> 6 == 2, "no UTF-8");
      code = code << 6 | (next & 63u);
    }
    static constexpr std::uint32_t kLeast[] = {0, 0x80, 0x800, 0x10000};
    require(code >= kLeast[more] && code < 0x110000 && (code < 0xD800 || code >= 0xE000), "no UTF-8");
    at += std::size_t(more) + 1;
  }
}

Json parsed(const std::string& text, bool fractions = false) {
  check_utf8(text);
  return Parser(text, fractions).whole();
}

inline void keys(const Json& of, const std::set<std::string>& expected, const std::string& what) {
  require(of.kind == Json::object, what + " is no object");
  std::set<std::string> found;
  for (const auto& [key, _] : of.members) found.insert(key);
  require(found == expected, what + " has other keys");
}
inline const std::vector<Json>& list(const Json& of) { require(of.kind == Json::list, "no list"); return of.items; }
inline const std::string& text(const Json& of) { require(of.kind == Json::text, "no text"); return of.string; }
inline Int whole(const Json& of) { require(of.kind == Json::number, "no number"); return of.value; }
inline bool truth(const Json& of) { require(of.kind == Json::boolean, "neither true nor false"); return of.truth; }
inline Texts texts(const Json& of) {
  Texts found;
  for (const Json& each : list(of)) found.push_back(text(each));
  return found;
}
inline Numbers numbers(const Json& of) {
  Numbers found;
  for (const Json& each : list(of)) found.push_back(whole(each));
  return found;
}
