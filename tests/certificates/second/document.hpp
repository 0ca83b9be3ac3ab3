// How a controller's document is asked: names of a type in the words of a section, and what has to be so.
#pragma once

#include "certificate.hpp"

using Names = std::set<std::string>;
using Modes = std::map<std::string, std::string>;

inline void agree(bool holds, const std::string& what) { if (!holds) throw Refuted(what); }

inline Names names_in(const Json& of) {
  const Texts all = texts(of);
  return {all.begin(), all.end()};
}
inline const Json& item(const Json& of, Int at) {
  require(at >= 0 && at < Int(list(of).size()), "a number of nothing");
  return of.items[std::size_t(at)];
}
inline std::string renamed(const Json& section, const char* kind, const std::string& name) {
  const auto of = section.at("names").members.find(kind);
  if (of == section.at("names").members.end()) return name;
  const auto own = of->second.members.find(name);
  return own == of->second.members.end() ? name : text(own->second);
}
inline Names renamed_all(const Json& section, const char* kind, const Json& of) {
  Names found;
  for (const std::string& name : texts(of)) found.insert(renamed(section, kind, name));
  return found;
}
// Whether two documents say the same.
inline bool same(const Json& one, const Json& other) {
  if (one.kind != other.kind || one.truth != other.truth || one.value != other.value || one.string != other.string) return false;
  if (one.items.size() != other.items.size() || one.members.size() != other.members.size()) return false;
  for (std::size_t i = 0; i < one.items.size(); ++i) if (!same(one.items[i], other.items[i])) return false;
  for (const auto& [key, each] : one.members) if (!other.members.count(key) || !same(each, other.members.at(key))) return false;
  return true;
}
