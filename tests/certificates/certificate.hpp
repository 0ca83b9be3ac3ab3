// How certificates are read in C++, from docs/certificates.md alone: the command line, the zip, JSON, the net, and its states.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iostream>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

using Int = std::int64_t;
__extension__ typedef __int128 Wide;
using Numbers = std::vector<Int>;
using Texts = std::vector<std::string>;

struct Malformed : std::runtime_error { using runtime_error::runtime_error; };
struct Limit : std::runtime_error { using runtime_error::runtime_error; };

[[noreturn]] inline void malformed(const std::string& what) { throw Malformed(what); }
inline void require(bool holds, const std::string& what) { if (!holds) malformed(what); }

// ---- the zip: stored or deflated entries, as its central directory lists them

constexpr std::size_t kMostUnpacked = std::size_t(64) << 20;

class Inflate {
 public:
  Inflate(const std::string& data, std::size_t size) : data_(data), size_(size) {}

  std::string all() {
    while (true) {
      const bool last = bits(1);
      switch (bits(2)) {
        case 0: stored(); break;
        case 1: fixed(); break;
        case 2: dynamic(); break;
        default: malformed("a block of no kind");
      }
      if (last) break;
    }
    require(out_.size() == size_, "an entry that unpacks to another size");
    return std::move(out_);
  }

 private:
  struct Code { std::array<int, 16> count{}; std::vector<int> symbols; };

  int bits(int many) {
    while (have_ < many) {
      require(at_ < data_.size(), "an entry that ends too early");
      buffer_ |= std::uint32_t(std::uint8_t(data_[at_++])) << have_;
      have_ += 8;
    }
    const int value = int(buffer_ & ((1u << many) - 1));
    buffer_ >>= many;
    have_ -= many;
    return value;
  }
  void put(char byte) {
    require(out_.size() < size_, "an entry that unpacks to more than it says");
    out_.push_back(byte);
  }
  void stored() {
    buffer_ = 0;
    have_ = 0;
    require(at_ + 4 <= data_.size(), "an entry that ends too early");
    const std::size_t size = std::uint8_t(data_[at_]) | std::size_t(std::uint8_t(data_[at_ + 1])) << 8;
    at_ += 4;
    require(size <= data_.size() - at_, "an entry that ends too early");
    for (std::size_t i = 0; i < size; ++i) put(data_[at_++]);
  }
  static Code code(const std::vector<int>& lengths) {
    Code made;
    for (const int length : lengths) ++made.count[std::size_t(length)];
    made.count[0] = 0;
    int left = 1;
    for (std::size_t length = 1; length < 16; ++length) {
      left = 2 * left - made.count[length];
      require(left >= 0, "a code of too many words");
    }
    for (int length = 1; length < 16; ++length)
      for (std::size_t symbol = 0; symbol < lengths.size(); ++symbol)
        if (lengths[symbol] == length) made.symbols.push_back(int(symbol));
    return made;
  }
  int decode(const Code& from) {
    int word = 0, first = 0, index = 0;
    for (std::size_t length = 1; length < 16; ++length) {
      word |= bits(1);
      const int count = from.count[length];
      if (word - count < first) return from.symbols[std::size_t(index + word - first)];
      index += count;
      first = (first + count) << 1;
      word <<= 1;
    }
    malformed("a word of no code");
  }
  void codes(const Code& literals, const Code& distances) {
    static constexpr int kLength[] = {3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 15, 17, 19, 23, 27, 31, 35, 43, 51, 59, 67, 83, 99, 115, 131, 163, 195, 227, 258};
    static constexpr int kLengthBits[] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0};
    static constexpr int kDistance[] = {1, 2, 3, 4, 5, 7, 9, 13, 17, 25, 33, 49, 65, 97, 129, 193, 257, 385, 513, 769, 1025, 1537, 2049, 3073, 4097, 6145, 8193, 12289, 16385, 24577};
    for (;;) {
      int symbol = decode(literals);
      if (symbol == 256) return;
      if (symbol < 256) { put(char(symbol)); continue; }
      symbol -= 257;
      require(symbol < 29, "a length of no kind");
      const int length = kLength[symbol] + bits(kLengthBits[symbol]);
      const int far = decode(distances);
      require(far < 30, "a distance of no kind");
      const std::size_t distance = std::size_t(kDistance[far] + bits(far < 2 ? 0 : (far - 2) / 2));
      require(distance <= out_.size(), "a distance before the beginning");
      for (int i = 0; i < length; ++i) put(out_[out_.size() - distance]);
    }
  }
  void fixed() {
    std::vector<int> lengths(288, 8);
    std::fill(lengths.begin() + 144, lengths.begin() + 256, 9);
    std::fill(lengths.begin() + 256, lengths.begin() + 280, 7);
    codes(code(lengths), code(std::vector<int>(30, 5)));
  }
  void dynamic() {
    static constexpr int kOrder[] = {16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15};
    const int literals = bits(5) + 257, distances = bits(5) + 1, coded = bits(4) + 4;
    std::vector<int> lengths(19);
    for (int i = 0; i < coded; ++i) lengths[std::size_t(kOrder[i])] = bits(3);
    const Code of_lengths = code(lengths);
    std::vector<int> all;
    while (int(all.size()) < literals + distances) {
      const int symbol = decode(of_lengths);
      int repeated = 0, many = 1;
      if (symbol < 16) repeated = symbol;
      else if (symbol == 16) {
        require(!all.empty(), "nothing to repeat");
        repeated = all.back();
        many = 3 + bits(2);
      } else many = symbol == 17 ? 3 + bits(3) : 11 + bits(7);
      all.insert(all.end(), std::size_t(many), repeated);
    }
    require(int(all.size()) == literals + distances, "too many lengths");
    codes(code({all.begin(), all.begin() + literals}), code({all.begin() + literals, all.end()}));
  }

  const std::string& data_;
  std::size_t size_, at_ = 0;
  std::uint32_t buffer_ = 0;
  int have_ = 0;
  std::string out_;
};

std::uint32_t crc32(const std::string& data) {
  std::uint32_t crc = ~0u;
  for (const char byte : data) {
    crc ^= std::uint8_t(byte);
    for (int i = 0; i < 8; ++i) crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320u : 0u);
  }
  return ~crc;
}

std::map<std::string, std::string> unzipped(const std::string& path, const std::set<std::string>& needed = {"net.json", "claims.json"}) {
  std::ifstream file(path, std::ios::binary);
  require(bool(file), "a file that cannot be read");
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  const auto number = [&](std::size_t at, int size) {
    require(at + std::size_t(size) <= bytes.size(), "a zip that ends too early");
    std::uint32_t value = 0;
    for (int i = 0; i < size; ++i) value |= std::uint32_t(std::uint8_t(bytes[at + std::size_t(i)])) << 8 * i;
    return value;
  };
  const std::size_t end = bytes.rfind("PK\5\6");
  require(end != std::string::npos, "no zip");
  const std::size_t entries = number(end + 10, 2);
  require(entries >= 2 && entries <= 6, "a zip with other than two to six entries");
  std::map<std::string, std::string> found;
  std::size_t at = number(end + 16, 4), unpacked = 0;
  for (std::size_t i = 0; i < entries; ++i) {
    require(number(at, 4) == 0x02014b50, "a directory that is none");
    const std::uint32_t flags = number(at + 8, 2), method = number(at + 10, 2), crc = number(at + 16, 4);
    const std::size_t packed = number(at + 20, 4), size = number(at + 24, 4), name_size = number(at + 28, 2);
    const std::size_t local = number(at + 42, 4);
    require(at + 46 + name_size <= bytes.size(), "a zip that ends too early");
    const std::string name = bytes.substr(at + 46, name_size);
    static const std::set<std::string> known = {"net.json", "claims.json", "core.json", "further.json", "diagrams.json", "sections.json"};
    require(known.count(name), "an unknown entry");
    require(!(flags & 1), "an encrypted entry");
    require(method == 0 || method == 8, "an entry packed in another way");
    unpacked += size;
    require(unpacked <= kMostUnpacked, "more than 64 MiB");
    require(number(local, 4) == 0x04034b50, "an entry that is none");
    const std::size_t begin = local + 30 + number(local + 26, 2) + number(local + 28, 2);
    require(begin <= bytes.size() && packed <= bytes.size() - begin, "a zip that ends too early");
    const std::string data = bytes.substr(begin, packed);
    require(method == 8 || packed == size, "an entry of another size");
    const std::string whole = method ? Inflate(data, size).all() : data;
    require(crc32(whole) == crc, "an entry with another checksum");
    require(found.emplace(name, whole).second, "an entry twice");
    at += 46 + name_size + number(at + 30, 2) + number(at + 32, 2);
  }
  for (const std::string& each : needed) require(found.count(each) > 0, "no " + each);
  return found;
}

// ---- JSON, in certificates without fractions

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

void check_utf8(const std::string& text) {
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

void keys(const Json& of, const std::set<std::string>& expected, const std::string& what) {
  require(of.kind == Json::object, what + " is no object");
  std::set<std::string> found;
  for (const auto& [key, _] : of.members) found.insert(key);
  require(found == expected, what + " has other keys");
}
const std::vector<Json>& list(const Json& of) { require(of.kind == Json::list, "no list"); return of.items; }
const std::string& text(const Json& of) { require(of.kind == Json::text, "no text"); return of.string; }
Int whole(const Json& of) { require(of.kind == Json::number, "no number"); return of.value; }
bool truth(const Json& of) { require(of.kind == Json::boolean, "neither true nor false"); return of.truth; }
Texts texts(const Json& of) {
  Texts found;
  for (const Json& each : list(of)) found.push_back(text(each));
  return found;
}
Numbers numbers(const Json& of) {
  Numbers found;
  for (const Json& each : list(of)) found.push_back(whole(each));
  return found;
}

// ---- the net and its states

using Marking = std::vector<bool>;
using Role = std::pair<std::string, std::string>;

struct Place { bool initial; std::set<Role> roles; };
struct Transition { Texts event; Int rank; Numbers consume, produce, read; bool internal() const { return event.empty(); } };
struct Net { std::vector<Place> places; std::vector<Transition> transitions; };
struct Edge { Int transition; std::size_t to; };

struct Unsafe {};
struct NotConfluent {};

struct Clock {
  std::size_t most = 10'000'000;
  double seconds = 1e9;
  std::chrono::steady_clock::time_point begun = std::chrono::steady_clock::now();
  void look(std::size_t states) const {
    if (states > most) throw Limit("more than " + std::to_string(most) + " states");
    if (std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count() > seconds) throw Limit("the seconds are over");
  }
};

// What a checker's command line asks for: the bound that it names, seconds, and the file. Exit code 2: not checked.
template <class Checked> int answered(int count, char** words, const std::string& bound, Checked checked) {
  Clock clock;
  std::string path;
  for (int i = 1; i < count; ++i) {
    const std::string word = words[i];
    if (word == bound && i + 1 < count) clock.most = std::strtoull(words[++i], nullptr, 10);
    else if (word == "--seconds" && i + 1 < count) clock.seconds = std::strtod(words[++i], nullptr);
    else path = word;
  }
  try {
    return checked(path, clock);
  } catch (const Malformed& error) {
    std::cerr << path << ": malformed: " << error.what() << '\n';
  } catch (const std::exception& error) {
    std::cerr << path << ": " << error.what() << '\n';
  }
  return 2;
}

void header(const Json& of) {
  require(text(of.at("format")) == "mcpn-certificate" && whole(of.at("version")) == 1, "another format or version");
}

Texts event_of(const Json& of) {
  Texts event = texts(of);
  require(event.empty() || event.size() == 2 || event.size() == 3, "an event that is none");
  return event;
}

Net net_of(const Json& of) {
  keys(of, {"format", "version", "places", "transitions"}, "net.json");
  header(of);
  Net net;
  std::set<std::string> names;
  for (const Json& each : list(of.at("places"))) {
    keys(each, {"name", "initial", "roles"}, "a place");
    require(names.insert(text(each.at("name"))).second, "two places of one name");
    const Int initial = whole(each.at("initial"));
    require(initial == 0 || initial == 1, "another initial marking than 0 or 1");
    Place place{initial == 1, {}};
    for (const Json& role : list(each.at("roles"))) {
      const Texts pair = texts(role);
      require(pair.size() == 2, "a role that is no pair");
      place.roles.emplace(pair[0], pair[1]);
    }
    net.places.push_back(std::move(place));
  }
  names.clear();
  for (const Json& each : list(of.at("transitions"))) {
    keys(each, {"name", "event", "rank", "consume", "produce", "read"}, "a transition");
    require(names.insert(text(each.at("name"))).second, "two transitions of one name");
    Transition made{event_of(each.at("event")), whole(each.at("rank")), {}, {}, {}};
    require(made.internal() || made.rank == 0, "an event with a rank");
    const auto side = [&](const char* key) {
      Numbers found = numbers(each.at(key));
      std::set<Int> once(found.begin(), found.end());
      require(once.size() == found.size(), "a place twice");
      require(found.empty() || (*once.begin() >= 0 && *once.rbegin() < Int(net.places.size())), "no such place");
      return found;
    };
    made.consume = side("consume");
    made.produce = side("produce");
    made.read = side("read");
    require(!made.internal() || !made.consume.empty() || !made.read.empty(), "an internal transition that nothing enables");
    net.transitions.push_back(std::move(made));
  }
  return net;
}

class States {
 public:
  States(const Net& net, const Clock& clock) : net_(net), clock_(clock) {
    Marking initial;
    for (const Place& place : net.places) initial.push_back(place.initial);
    number(end_of(initial));
    for (std::size_t s = 0; s < markings.size(); ++s) {
      clock.look(markings.size() + ends_.size());
      edges.emplace_back();
      for (std::size_t t = 0; t < net.transitions.size(); ++t) {
        if (net.transitions[t].internal() || !covered(net.transitions[t], markings[s])) continue;
        const Marking end = end_of(fired(net.transitions[t], markings[s]));
        edges[s].push_back({Int(t), number(end)});
      }
    }
  }

  std::vector<Marking> markings;
  std::vector<std::vector<Edge>> edges;

  bool says(std::size_t state, const std::string& role, const std::string& element) const {
    return marks(state, [&](const Role& found) { return found.first == role && found.second == element; });
  }
  bool ends(std::size_t state, const std::set<std::string>& roles) const {
    return marks(state, [&](const Role& found) { return roles.count(found.first) > 0; });
  }

 private:
  template <class Is> bool marks(std::size_t state, Is is) const {
    for (std::size_t p = 0; p < net_.places.size(); ++p)
      if (markings[state][p] && std::any_of(net_.places[p].roles.begin(), net_.places[p].roles.end(), is)) return true;
    return false;
  }
  static bool covered(const Transition& t, const Marking& in) {
    const auto marked = [&](Int place) { return bool(in[std::size_t(place)]); };
    return std::all_of(t.consume.begin(), t.consume.end(), marked) && std::all_of(t.read.begin(), t.read.end(), marked);
  }
  static Marking fired(const Transition& t, Marking in) {
    for (const Int place : t.consume) in[std::size_t(place)] = false;
    for (const Int place : t.produce) {
      if (in[std::size_t(place)]) throw Unsafe();
      in[std::size_t(place)] = true;
    }
    return in;
  }
  std::vector<std::size_t> permitted(const Marking& in) const {
    std::vector<std::size_t> found;
    for (std::size_t t = 0; t < net_.transitions.size(); ++t) {
      const Transition& one = net_.transitions[t];
      if (!one.internal() || !covered(one, in)) continue;
      if (!found.empty() && one.rank < net_.transitions[found[0]].rank) found.clear();
      if (found.empty() || one.rank == net_.transitions[found[0]].rank) found.push_back(t);
    }
    return found;
  }
  // Every order of internal firings is followed, depth first.
  Marking end_of(const Marking& from) {
    struct Frame { Marking at; std::vector<std::size_t> left; std::unique_ptr<Marking> end; };
    std::set<Marking> underway;
    std::vector<Frame> stack;
    Marking result;
    const auto enter = [&](const Marking& at) {
      if (const auto known = ends_.find(at); known != ends_.end()) { result = known->second; return true; }
      if (underway.count(at)) throw NotConfluent();
      std::vector<std::size_t> next = permitted(at);
      if (next.empty()) { result = at; return true; }
      clock_.look(ends_.size() + underway.size());
      underway.insert(at);
      stack.push_back({at, std::move(next), nullptr});
      return false;
    };
    bool known = enter(from);
    while (!stack.empty()) {
      Frame& top = stack.back();
      if (known) {
        if (top.end && *top.end != result) throw NotConfluent();
        if (!top.end) top.end = std::make_unique<Marking>(result);
        known = false;
      }
      if (top.left.empty()) {
        result = *top.end;
        ends_.emplace(top.at, result);
        underway.erase(top.at);
        stack.pop_back();
        known = true;
        continue;
      }
      const std::size_t t = top.left.back();
      top.left.pop_back();
      known = enter(fired(net_.transitions[t], top.at));
    }
    return result;
  }
  std::size_t number(const Marking& of) {
    const auto [found, fresh] = numbers_.emplace(of, markings.size());
    if (fresh) markings.push_back(of);
    return found->second;
  }

  const Net& net_;
  const Clock& clock_;
  std::unordered_map<Marking, Marking> ends_;
  std::unordered_map<Marking, std::size_t> numbers_;
};
