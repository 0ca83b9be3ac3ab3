// A second checker of certificates, written from docs/certificates.md alone: c++ -O2 -std=c++17 checker.cpp -o checker.
//
// checker FILE [--max-states N] [--seconds S] prints "VERDICT KEY" for each claim, where VERDICT is proved, refuted or not checked,
// and ends with 0 if all are proved, 1 if some is refuted, else 2. What is malformed is told in one sentence, with exit code 2.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iostream>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

using Int = std::int64_t;
using Wide = __int128;
using Numbers = std::vector<Int>;
using Texts = std::vector<std::string>;

struct Malformed : std::runtime_error { using runtime_error::runtime_error; };
struct Limit : std::runtime_error { using runtime_error::runtime_error; };

[[noreturn]] void malformed(const std::string& what) { throw Malformed(what); }
void require(bool holds, const std::string& what) { if (!holds) malformed(what); }

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

std::map<std::string, std::string> unzipped(const std::string& path) {
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
  require(entries >= 2 && entries <= 5, "a zip with other than two to five entries");
  std::map<std::string, std::string> found;
  std::size_t at = number(end + 16, 4), unpacked = 0;
  for (std::size_t i = 0; i < entries; ++i) {
    require(number(at, 4) == 0x02014b50, "a directory that is none");
    const std::uint32_t flags = number(at + 8, 2), method = number(at + 10, 2), crc = number(at + 16, 4);
    const std::size_t packed = number(at + 20, 4), size = number(at + 24, 4), name_size = number(at + 28, 2);
    const std::size_t local = number(at + 42, 4);
    require(at + 46 + name_size <= bytes.size(), "a zip that ends too early");
    const std::string name = bytes.substr(at + 46, name_size);
    static const std::set<std::string> known = {"net.json", "claims.json", "core.json", "further.json", "diagrams.json"};
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
  require(found.count("net.json") && found.count("claims.json"), "no net.json, or no claims.json");
  return found;
}

// ---- JSON without fractions

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
  explicit Parser(const std::string& text) : text_(text) {}
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

Json parsed(const std::string& text) {
  check_utf8(text);
  return Parser(text).whole();
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

// ---- claims

using Set = std::vector<bool>;  // of states
const std::set<std::string> kEnds{"success", "failure", "abort"};

class Claims {
 public:
  Claims(const Net& net, const States& states, const Clock& clock) : net_(net), states_(states), clock_(clock), count_(states.markings.size()) {}

  bool proved(const std::string& kind, bool holds, const Json& statement, const Json& evidence) {
    if (kind == "safe" || kind == "confluent") return holds;
    if (kind == "can_always_go_on") return go_on(holds, evidence);
    if (kind == "can_succeed") return can_end(holds, evidence, "success");
    if (kind == "can_fail") return can_end(holds, evidence, "failure");
    if (kind == "can_be_aborted") return can_end(holds, evidence, "abort");
    if (kind == "can_always_end") return always(holds, evidence, kEnds);
    if (kind == "can_always_end_safely") return always(holds, evidence, {"success", "abort"});
    if (kind == "nominal_success") return holds && nominal(statement, numbers(evidence.at("numbers")));
    if (kind == "cut_sets") return holds && cuts(statement, evidence.at("survived"));
    return on_states(statement.at("formula"))[0] == holds;
  }

  // What a kind asks for; whatever else makes the file malformed.
  void shape(const std::string& kind, bool holds, const Json& statement, const Json& evidence) const {
    const bool always = kind == "can_always_end" || kind == "can_always_end_safely";
    const bool can = kind == "can_succeed" || kind == "can_fail" || kind == "can_be_aborted";
    std::set<std::string> stated, shown;
    if (kind == "nominal_success") {
      stated = {"fails", "endless", "meant", "repaired"};
      shown = {"numbers"};
    } else if (kind == "cut_sets") {
      stated = {"ends", "hardware", "cuts"};
      shown = {"survived"};
    } else if (kind == "can_always_go_on") {
      if (!holds) shown = {"run"};
    } else if (can) {
      if (holds) shown = {"run"};
    } else if (always) {
      shown = {holds ? "numbers" : "run"};
    } else if (kind != "safe" && kind != "confluent") {
      stated = {"text", "formula"};
    }
    keys(statement, stated, "a statement");
    keys(evidence, shown, "evidence");
    if (shown.count("run")) check_run(evidence.at("run"));
    if (shown.count("numbers")) numbers(evidence.at("numbers"));
    if (stated.count("fails")) for (const auto& key : stated) texts(statement.at(key));
    if (stated.count("cuts")) {
      texts(statement.at("ends"));
      texts(statement.at("hardware"));
      for (const Json& each : list(statement.at("cuts"))) texts(each);
      for (const Json& each : list(evidence.at("survived"))) {
        keys(each, {"lost", "by", "run"}, "a set that is survived");
        texts(each.at("lost"));
        whole(each.at("by"));
        check_run(each.at("run"));
      }
    }
    if (stated.count("formula")) {
      text(statement.at("text"));
      shape_of_formula(statement.at("formula"), false, 0);
    }
  }

 private:
  void check_run(const Json& run) const { numbers(run); }

  // The state after a run; none where it cannot be followed.
  bool follow(const Numbers& run, std::size_t& state) const {
    for (const Int t : run) {
      const auto& out = states_.edges[state];
      const auto edge = std::find_if(out.begin(), out.end(), [&](const Edge& each) { return each.transition == t; });
      if (edge == out.end()) return false;
      state = edge->to;
    }
    return true;
  }
  bool go_on(bool holds, const Json& evidence) const {
    const auto stuck = [&](std::size_t s) { return states_.edges[s].empty() && !states_.ends(s, kEnds); };
    if (!holds) {
      std::size_t state = 0;
      return follow(numbers(evidence.at("run")), state) && stuck(state);
    }
    for (std::size_t s = 0; s < count_; ++s) if (stuck(s)) return false;
    return true;
  }
  bool can_end(bool holds, const Json& evidence, const std::string& role) const {
    if (holds) {
      std::size_t state = 0;
      return follow(numbers(evidence.at("run")), state) && states_.ends(state, {role});
    }
    for (std::size_t s = 0; s < count_; ++s) if (states_.ends(s, {role})) return false;
    return true;
  }
  bool always(bool holds, const Json& evidence, const std::set<std::string>& roles) const {
    if (!holds) {
      std::size_t state = 0;
      if (!follow(numbers(evidence.at("run")), state)) return false;
      const Set seen = from({state}, [](const Edge&) { return true; });
      for (std::size_t s = 0; s < count_; ++s) if (seen[s] && states_.ends(s, roles)) return false;
      return true;
    }
    const Numbers falls = numbers(evidence.at("numbers"));
    if (falls.size() != count_) return false;
    for (std::size_t s = 0; s < count_; ++s) {
      if (states_.ends(s, roles)) continue;
      const auto& out = states_.edges[s];
      if (std::none_of(out.begin(), out.end(), [&](const Edge& each) { return falls[each.to] >= 0 && falls[each.to] < falls[s]; })) return false;
    }
    return true;
  }
  template <class May> Set from(std::vector<std::size_t> stack, May may) const {
    Set seen(count_);
    for (const std::size_t s : stack) seen[s] = true;
    while (!stack.empty()) {
      const std::size_t s = stack.back();
      stack.pop_back();
      for (const Edge& edge : states_.edges[s])
        if (may(edge) && !seen[edge.to]) { seen[edge.to] = true; stack.push_back(edge.to); }
    }
    return seen;
  }
  const Texts& event(const Edge& edge) const { return net_.transitions[std::size_t(edge.transition)].event; }
  bool is(const Edge& edge, const std::string& what, const std::set<std::string>& of) const {
    return event(edge)[0] == what && of.count(event(edge)[1]) > 0;
  }

  bool nominal(const Json& statement, const Numbers& falls) const {
    if (falls.size() != count_) return false;
    const auto names = [&](const char* key) { const Texts all = texts(statement.at(key)); return std::set<std::string>(all.begin(), all.end()); };
    const std::set<std::string> fails = names("fails"), endless = names("endless"), meant = names("meant"), repaired = names("repaired");
    const auto is_nominal = [&](const Edge& edge) {
      const Texts& what = event(edge);
      if (what[0] == "start") return true;
      if (what[0] == "success") return fails.count(what[1]) == 0;
      return what[0] == "failure" && fails.count(what[1]) > 0;
    };
    const Set mended = from({0}, [&](const Edge& edge) { return is(edge, "repaired", repaired); });
    std::vector<std::size_t> starts;
    for (std::size_t s = 0; s < count_; ++s)
      if (mended[s] && std::none_of(repaired.begin(), repaired.end(), [&](const std::string& name) { return states_.says(s, "oos", name); })) starts.push_back(s);
    if (starts.empty()) return false;
    const Set reached = from(starts, is_nominal);
    const auto exempt = [&](std::size_t s) {
      return states_.ends(s, {"success"}) || std::any_of(endless.begin(), endless.end(), [&](const std::string& name) { return states_.says(s, "objective", name); });
    };
    std::set<std::string> missing = meant;
    for (std::size_t s = 0; s < count_; ++s) {
      if (falls[s] < 0) return false;
      if (!reached[s]) continue;
      bool goes_on = states_.ends(s, {"success"});
      for (const Edge& edge : states_.edges[s]) {
        if (!is_nominal(edge)) continue;
        goes_on = true;
        if (!exempt(s) && !exempt(edge.to) && falls[edge.to] >= falls[s]) return false;
      }
      if (!goes_on) return false;
      for (const std::string& name : meant) if (states_.says(s, "objective", name)) missing.erase(name);
    }
    return missing.empty();
  }

  // ---- cut sets

  using Mask = std::vector<bool>;
  struct Counting {
    std::map<std::pair<std::size_t, std::set<Mask>>, Wide> known;
    std::size_t size;
    const Clock& clock;
    // Sets of the elements from one on that hold a set of some.
    Wide above(std::size_t element, const std::set<Mask>& sets) {
      if (sets.empty()) return 0;
      if (sets.count(Mask(size))) return Wide(1) << (size - element);
      const auto key = std::make_pair(element, sets);
      if (const auto found = known.find(key); found != known.end()) return found->second;
      clock.look(known.size());
      std::set<Mask> without, with;
      for (Mask each : sets) {
        if (!each[element]) without.insert(each);
        each[element] = false;
        with.insert(each);
      }
      return known[key] = above(element + 1, without) + above(element + 1, with);
    }
  };
  bool cuts(const Json& statement, const Json& survived) const {
    const Texts names = texts(statement.at("hardware"));
    const Texts given = texts(statement.at("ends"));
    const std::set<std::string> goals(given.begin(), given.end());
    std::map<std::string, std::size_t> number;
    for (const std::string& name : names) if (!number.emplace(name, number.size()).second) return false;
    std::set<std::string> hardware;
    for (const Place& place : net_.places) for (const Role& role : place.roles) if (role.first == "oos") hardware.insert(role.second);
    if (hardware != std::set<std::string>(names.begin(), names.end())) return false;
    if (names.size() > 120) throw Limit("more than 120 hardware resources");
    const auto mask = [&](const Texts& of, Mask& made) {
      made.assign(names.size(), false);
      for (const std::string& name : of) {
        const auto found = number.find(name);
        if (found == number.end() || made[found->second]) return false;
        made[found->second] = true;
      }
      return true;
    };
    const auto is_start = [&](std::size_t s, const Texts& lost) {
      return states_.ends(s, {"begin"}) && std::all_of(lost.begin(), lost.end(), [&](const std::string& name) { return states_.says(s, "oos", name); });
    };
    const auto kept = [&](const Edge& edge, const Texts& lost) { return !is(edge, "repaired", {lost.begin(), lost.end()}); };
    std::set<Mask> cut_masks, lost_masks;
    for (const Json& each : list(statement.at("cuts"))) {
      const Texts cut = texts(each);
      Mask made;
      if (!mask(cut, made)) return false;
      std::vector<std::size_t> starts;
      for (std::size_t s = 0; s < count_; ++s) if (is_start(s, cut)) starts.push_back(s);
      const Set reached = from(starts, [&](const Edge& edge) { return kept(edge, cut); });
      for (std::size_t s = 0; s < count_; ++s) if (reached[s] && states_.ends(s, goals)) return false;
      cut_masks.insert(made);
    }
    for (const Json& each : list(survived)) {
      const Texts lost = texts(each.at("lost"));
      Mask made;
      if (!mask(lost, made)) return false;
      const Numbers run = numbers(each.at("run"));
      const Int by = std::clamp<Int>(whole(each.at("by")), 0, Int(run.size()));
      std::size_t state = 0;
      if (!follow({run.begin(), run.begin() + by}, state) || !is_start(state, lost)) return false;
      for (auto t = run.begin() + by; t != run.end(); ++t) {
        const auto& out = states_.edges[state];
        const auto edge = std::find_if(out.begin(), out.end(), [&](const Edge& one) { return one.transition == *t; });
        if (edge == out.end() || !kept(*edge, lost)) return false;
        state = edge->to;
      }
      if (!states_.ends(state, goals)) return false;
      lost_masks.insert(made);
    }
    const auto within = [&](const Mask& small, const Mask& large) {
      for (std::size_t i = 0; i < names.size(); ++i) if (small[i] && !large[i]) return false;
      return true;
    };
    for (const Mask& cut : cut_masks) {
      for (const Mask& other : cut_masks) if (other != cut && within(cut, other)) return false;
      for (std::size_t i = 0; i < names.size(); ++i) {
        if (!cut[i]) continue;
        Mask less = cut;
        less[i] = false;
        if (std::none_of(lost_masks.begin(), lost_masks.end(), [&](const Mask& lost) { return within(less, lost); })) return false;
      }
    }
    std::set<Mask> others;  // part of a set is what holds, complemented, that set's complement
    for (Mask each : lost_masks) { each.flip(); others.insert(each); }
    Counting up{{}, names.size(), clock_}, down{{}, names.size(), clock_};
    return up.above(0, cut_masks) + down.above(0, others) == Wide(1) << names.size();
  }

  // ---- formulas

  void shape_of_formula(const Json& of, bool on_paths, int depth) const {
    require(depth < 1000, "a formula that is nested too deep");
    const auto& parts = list(of);
    require(!parts.empty(), "an empty formula");
    const std::string& op = text(parts[0]);
    const auto rest = [&](std::size_t count, bool paths) {
      require(count == 0 || parts.size() == count + 1, "a formula with other parts: " + op);
      for (std::size_t i = 1; i < parts.size(); ++i) shape_of_formula(parts[i], paths, depth + 1);
    };
    if (op == "says") {
      require(texts(of).size() == 3, "a formula with other parts: says");
    } else if (op == "at most") {
      require(parts.size() == 3, "a formula with other parts: at most");
      whole(parts[1]);
      for (const Json& each : list(parts[2])) {
        const Numbers pair = numbers(each);
        require(pair.size() == 2 && pair[0] >= 0 && pair[0] < Int(net_.places.size()), "no weight of a place");
      }
    } else if (op == "fires" || (op == "happens" && on_paths)) {
      for (std::size_t i = 1; i < parts.size(); ++i) texts(parts[i]);
    } else if (op == "deadlock") {
      rest(0, false);
      require(parts.size() == 1, "a formula with other parts: deadlock");
    } else if (op == "not") {
      rest(1, on_paths);
    } else if (op == "and" || op == "or") {
      rest(0, on_paths);
    } else if (op == "EX" || op == "EG") {
      rest(1, false);
    } else if (op == "EU") {
      rest(2, false);
    } else if (op == "E") {
      rest(1, true);
    } else if (on_paths && op == "X") {
      rest(1, true);
    } else if (on_paths && (op == "U" || op == "R")) {
      rest(2, true);
    } else {
      malformed("a formula that is none: " + op);
    }
  }
  bool among(const Edge& edge, const std::vector<Json>& parts) const {
    for (std::size_t i = 1; i < parts.size(); ++i) if (texts(parts[i]) == event(edge)) return true;
    return false;
  }
  Set on_states(const Json& of) {
    const auto& parts = of.items;
    const std::string& op = parts[0].string;
    Set found(count_);
    const auto each = [&](auto is) { for (std::size_t s = 0; s < count_; ++s) found[s] = is(s); };
    if (op == "says") {
      each([&](std::size_t s) { return states_.says(s, parts[1].string, parts[2].string); });
    } else if (op == "at most") {
      each([&](std::size_t s) {
        Wide sum = 0;
        for (const Json& pair : parts[2].items) if (states_.markings[s][std::size_t(pair.items[0].value)]) sum += pair.items[1].value;
        return sum <= parts[1].value;
      });
    } else if (op == "fires") {
      each([&](std::size_t s) { const auto& out = states_.edges[s]; return std::any_of(out.begin(), out.end(), [&](const Edge& edge) { return among(edge, parts); }); });
    } else if (op == "deadlock") {
      each([&](std::size_t s) { return states_.edges[s].empty(); });
    } else if (op == "not") {
      found = on_states(parts[1]);
      found.flip();
    } else if (op == "and" || op == "or") {
      const bool all = op == "and";
      found.assign(count_, all);
      for (std::size_t i = 1; i < parts.size(); ++i) {
        const Set part = on_states(parts[i]);
        each([&](std::size_t s) { return all ? found[s] && part[s] : found[s] || part[s]; });
      }
    } else if (op == "EX") {
      const Set next = on_states(parts[1]);
      each([&](std::size_t s) { const auto& out = states_.edges[s]; return std::any_of(out.begin(), out.end(), [&](const Edge& edge) { return bool(next[edge.to]); }); });
    } else if (op == "EU") {
      const Set through = on_states(parts[1]);
      found = on_states(parts[2]);
      grow(found, through);
    } else if (op == "EG") {
      found = on_states(parts[1]);
      for (bool changed = true; changed;) {
        changed = false;
        clock_.look(0);
        for (std::size_t s = 0; s < count_; ++s) {
          const auto& out = states_.edges[s];
          if (found[s] && !out.empty() && std::none_of(out.begin(), out.end(), [&](const Edge& edge) { return bool(found[edge.to]); })) {
            found[s] = false;
            changed = true;
          }
        }
      }
    } else {
      found = some_path(parts[1]);
    }
    return found;
  }
  void grow(Set& found, const Set& through) const {
    for (bool changed = true; changed;) {
      changed = false;
      clock_.look(0);
      for (std::size_t s = count_; s-- > 0;) {
        const auto& out = states_.edges[s];
        if (!found[s] && through[s] && std::any_of(out.begin(), out.end(), [&](const Edge& edge) { return bool(found[edge.to]); })) {
          found[s] = true;
          changed = true;
        }
      }
    }
  }

  // ---- paths: nodes are a state, the step that is taken there, and what is promised of the next node

  struct Part { enum Op { state, happens, negation, all, any, next, until } op; Set set; const Json* of = nullptr; std::vector<std::size_t> parts; int promise = -1; };
  std::size_t part_of(const Json& of, std::vector<Part>& parts, int& promises) {
    const std::string& op = of.items[0].string;
    Part made{Part::state, {}, &of, {}, -1};
    const auto inner = [&](std::size_t i) { return part_of(of.items[i], parts, promises); };
    const auto add = [&](Part part) { parts.push_back(std::move(part)); return parts.size() - 1; };
    const auto negated = [&](std::size_t part) { return add({Part::negation, {}, nullptr, {part}, -1}); };
    if (op == "happens") made.op = Part::happens;
    else if (op == "not") { made.op = Part::negation; made.parts = {inner(1)}; }
    else if (op == "and" || op == "or") {
      made.op = op == "and" ? Part::all : Part::any;
      for (std::size_t i = 1; i < of.items.size(); ++i) made.parts.push_back(inner(i));
    } else if (op == "X") { made.op = Part::next; made.parts = {inner(1)}; made.promise = promises++; }
    else if (op == "U") { made.op = Part::until; made.parts = {inner(1), inner(2)}; made.promise = promises++; }
    else if (op == "R") {
      const std::size_t first = negated(inner(1)), second = negated(inner(2));
      return negated(add({Part::until, {}, nullptr, {first, second}, promises++}));
    } else made.set = on_states(of);
    return add(std::move(made));
  }
  Set some_path(const Json& formula) {
    std::vector<Part> parts;
    int promises = 0;
    const std::size_t top = part_of(formula, parts, promises);
    if (promises > 16) throw Limit("a formula on paths with more than 16 promises");
    const std::size_t kinds = std::size_t(1) << promises;
    // Nodes: for each state its steps, one that repeats where there is none; for each step the promises.
    std::vector<std::size_t> first{0};
    for (std::size_t s = 0; s < count_; ++s) first.push_back(first.back() + std::max<std::size_t>(1, states_.edges[s].size()));
    const std::size_t count = first.back() * kinds;
    if (count > (std::size_t(1) << 26)) throw Limit("too many nodes beside a formula on paths");
    clock_.look(0);
    std::vector<std::vector<bool>> holds(parts.size(), std::vector<bool>(count));
    for (std::size_t s = 0; s < count_; ++s) {
      for (std::size_t step = first[s]; step < first[s + 1]; ++step) {
        for (std::size_t kind = 0; kind < kinds; ++kind) {
          const std::size_t node = step * kinds + kind;
          for (std::size_t i = 0; i < parts.size(); ++i) {
            const Part& part = parts[i];
            const auto inner = [&](std::size_t which) { return bool(holds[part.parts[which]][node]); };
            bool is = false;
            switch (part.op) {
              case Part::state: is = part.set[s]; break;
              case Part::happens: is = !states_.edges[s].empty() && among(states_.edges[s][step - first[s]], part.of->items); break;
              case Part::negation: is = !inner(0); break;
              case Part::all: is = true; for (std::size_t k = 0; k < part.parts.size(); ++k) is = is && inner(k); break;
              case Part::any: for (std::size_t k = 0; k < part.parts.size(); ++k) is = is || inner(k); break;
              case Part::next: is = kind >> part.promise & 1; break;
              case Part::until: is = inner(1) || (inner(0) && (kind >> part.promise & 1)); break;
            }
            holds[i][node] = is;
          }
        }
      }
    }
    // What is promised of a node: the part behind an X, an until itself.
    const auto promised = [&](std::size_t node) {
      std::size_t kind = 0;
      for (std::size_t i = 0; i < parts.size(); ++i) {
        const Part& part = parts[i];
        if (part.op == Part::next && holds[part.parts[0]][node]) kind |= std::size_t(1) << part.promise;
        if (part.op == Part::until && holds[i][node]) kind |= std::size_t(1) << part.promise;
      }
      return kind;
    };
    std::vector<std::uint32_t> made(count);
    for (std::size_t node = 0; node < count; ++node) made[node] = std::uint32_t(promised(node));
    const auto state_of = [&](std::size_t step) { return std::size_t(std::upper_bound(first.begin(), first.end(), step) - first.begin()) - 1; };
    const auto for_next = [&](std::size_t node, auto&& then) {
      const std::size_t step = node / kinds, kind = node % kinds, s = state_of(step);
      const std::size_t to = states_.edges[s].empty() ? s : states_.edges[s][step - first[s]].to;
      for (std::size_t next = first[to] * kinds; next < first[to + 1] * kinds; ++next) if (made[next] == kind) then(next);
    };
    return accepted(count, kinds, first, parts, holds, top, for_next, state_of);
  }
  // States with a node of the formula that leads to a strongly connected component in which no until is put off for ever.
  template <class Next, class StateOf>
  Set accepted(std::size_t count, std::size_t kinds, const std::vector<std::size_t>&, const std::vector<Part>& parts,
               const std::vector<std::vector<bool>>& holds, std::size_t top, const Next& for_next, const StateOf& state_of) const {
    std::vector<std::size_t> index(count), low(count), stack, component(count);
    std::vector<bool> on_stack(count), good(count);
    std::size_t counter = 0;
    struct Frame { std::size_t node; std::vector<std::size_t> next; std::size_t at; };
    for (std::size_t root = 0; root < count; ++root) {
      if (index[root]) continue;
      std::vector<Frame> frames;
      const auto enter = [&](std::size_t node) {
        index[node] = low[node] = ++counter;
        stack.push_back(node);
        on_stack[node] = true;
        Frame frame{node, {}, 0};
        for_next(node, [&](std::size_t next) { frame.next.push_back(next); });
        frames.push_back(std::move(frame));
        if (counter % 4096 == 0) clock_.look(0);
      };
      enter(root);
      while (!frames.empty()) {
        Frame& top_frame = frames.back();
        if (top_frame.at < top_frame.next.size()) {
          const std::size_t next = top_frame.next[top_frame.at++];
          if (!index[next]) enter(next);
          else if (on_stack[next]) low[top_frame.node] = std::min(low[top_frame.node], index[next]);
          continue;
        }
        const std::size_t node = top_frame.node;
        if (low[node] == index[node]) {
          std::vector<std::size_t> members;
          for (;;) {
            const std::size_t member = stack.back();
            stack.pop_back();
            on_stack[member] = false;
            members.push_back(member);
            if (member == node) break;
          }
          bool leads = members.size() > 1, reaches = false;
          for (const std::size_t member : members)
            for_next(member, [&](std::size_t next) { leads = leads || next == member; reaches = reaches || good[next]; });
          for (std::size_t i = 0; leads && i < parts.size(); ++i)
            if (parts[i].op == Part::until)
              leads = std::any_of(members.begin(), members.end(), [&](std::size_t member) { return !holds[i][member] || holds[parts[i].parts[1]][member]; });
          for (const std::size_t member : members) good[member] = leads || reaches;
        }
        frames.pop_back();
        if (!frames.empty()) low[frames.back().node] = std::min(low[frames.back().node], low[node]);
      }
    }
    Set found(count_);
    for (std::size_t node = 0; node < count; ++node) if (good[node] && holds[top][node]) found[state_of(node / kinds)] = true;
    return found;
  }

  const Net& net_;
  const States& states_;
  const Clock& clock_;
  std::size_t count_;
};

int checked(const std::string& path, const Clock& clock) {
  const auto files = unzipped(path);
  const Net net = net_of(parsed(files.at("net.json")));
  const Json claims = parsed(files.at("claims.json"));
  keys(claims, {"format", "version", "mission", "claims", "trusted"}, "claims.json");
  header(claims);
  text(claims.at("mission"));
  for (const Json& each : list(claims.at("trusted"))) {
    keys(each, {"key", "sentence", "why"}, "what is trusted");
    for (const auto& [_, value] : each.members) text(value);
  }
  std::set<std::string> once;
  for (const Json& each : list(claims.at("claims"))) {
    keys(each, {"key", "kind", "subject", "holds", "sentence", "statement", "evidence"}, "a claim");
    require(once.insert(text(each.at("key"))).second, "two claims of one key");
    texts(each.at("subject"));
    text(each.at("sentence"));
    text(each.at("kind"));
    truth(each.at("holds"));
    for (const char* key : {"statement", "evidence"}) require(each.at(key).kind == Json::object, "a claim without an object");
  }
  std::unique_ptr<States> states;
  std::string broken, why;
  try {
    states = std::make_unique<States>(net, clock);
  } catch (const Unsafe&) {
    broken = "safe";
  } catch (const NotConfluent&) {
    broken = "confluent";
  } catch (const Limit& limit) {
    why = limit.what();
  }
  if (states)  // else no claim is looked into
    for (const Json& each : claims.at("claims").items)
      Claims(net, *states, clock).shape(each.at("kind").string, each.at("holds").truth, each.at("statement"), each.at("evidence"));
  bool refuted = false, open = false;
  for (const Json& each : claims.at("claims").items) {
    const std::string& kind = each.at("kind").string;
    std::string verdict = "not checked";
    if (states) {
      try {
        Claims of(net, *states, clock);
        verdict = of.proved(kind, each.at("holds").truth, each.at("statement"), each.at("evidence")) ? "proved" : "refuted";
      } catch (const Limit& limit) {
        why = limit.what();
      }
    } else if (kind == broken) {
      verdict = "refuted";
    }
    refuted = refuted || verdict == "refuted";
    open = open || verdict == "not checked";
    std::cout << verdict << ' ' << each.at("key").string << '\n';
  }
  for (const char* further : {"further.json", "diagrams.json"})  // which it does not read
    if (files.count(further)) {
      open = true;
      std::cout << "not checked " << further << '\n';
    }
  if (!why.empty()) std::cerr << "limit: " << why << '\n';
  return refuted ? 1 : open ? 2 : 0;
}

int main(int count, char** words) {
  Clock clock;
  std::string path;
  for (int i = 1; i < count; ++i) {
    const std::string word = words[i];
    if (word == "--max-states" && i + 1 < count) clock.most = std::strtoull(words[++i], nullptr, 10);
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
