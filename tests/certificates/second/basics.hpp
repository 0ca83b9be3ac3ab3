// What every checker in C++ uses: numbers, texts, and what is thrown where a file is malformed or a limit is hit.
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
struct Refuted : std::runtime_error { using runtime_error::runtime_error; };
struct Limit : std::runtime_error { using runtime_error::runtime_error; };

[[noreturn]] inline void malformed(const std::string& what) { throw Malformed(what); }
inline void require(bool holds, const std::string& what) { if (!holds) malformed(what); }
