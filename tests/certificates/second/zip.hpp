// A zip, read in C++: stored or deflated entries, as its central directory lists them.
#pragma once

#include "basics.hpp"

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

inline std::uint32_t crc32(const std::string& data) {
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
  require(entries >= needed.size() && entries <= 6, "a zip with too few or too many entries");
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
