// What further claims state and show, and which keys and types they have.
#pragma once

#include "cut_sets.hpp"

inline bool of_cut_sets(const std::string& kind) { return kind.rfind("cut_sets_", 0) == 0; }

inline void shape_of_cut_sets(const std::string& kind, const Json& statement, const Json& evidence) {
  std::set<std::string> stated{"goal", "hardware", "cuts", "stopped"};
  if (kind == "cut_sets_at_entry") stated.insert({"entered", "inside", "again"});
  if (kind == "cut_sets_at_worst") stated.insert({"over", "timed"});
  keys(statement, stated, "a statement");
  keys(statement.at("goal"), {"ends", "objective"}, "a goal");
  texts(statement.at("goal").at("ends"));
  text(statement.at("goal").at("objective"));
  for (const char* key : {"hardware", "entered", "again", "over"}) if (stated.count(key)) texts(statement.at(key));
  for (const char* key : {"cuts", "inside", "timed"})
    if (stated.count(key)) for (const Json& each : list(statement.at(key))) texts(each);
  if (kind == "cut_sets_at_worst") return keys(evidence, {}, "evidence");
  keys(evidence, {"survived"}, "evidence");
  CutSets::shape_of_survived(evidence.at("survived"));
}

inline void shape_of_chance(const Json& statement, const Json& evidence) {
  keys(statement, {"end", "low", "high", "hardware", "objectives", "events", "stopped"}, "a statement");
  for (const char* key : {"end", "low", "high"}) text(statement.at(key));
  for (const Json& each : list(statement.at("hardware"))) {
    keys(each, {"name", "fails", "repaired"}, "hardware");
    text(each.at("name"));
    for (const char* key : {"fails", "repaired"}) texts(each.at(key));
  }
  for (const Json& each : list(statement.at("objectives"))) {
    keys(each, {"name", "duration", "failures"}, "an objective");
    for (const char* key : {"name", "duration"}) text(each.at(key));
    for (const Json& failure : list(each.at("failures"))) texts(failure);
  }
  for (const Json& each : list(statement.at("events"))) {
    keys(each, {"event", "rate"}, "an event");
    for (const char* key : {"event", "rate"}) texts(each.at(key));
  }
  keys(evidence, {"above", "below"}, "evidence");
  for (const char* key : {"above", "below"}) numbers(evidence.at(key));
}

inline void shape(const Json& claim) {
  const std::string& kind = claim.at("kind").string;
  if (of_cut_sets(kind)) shape_of_cut_sets(kind, claim.at("statement"), claim.at("evidence"));
  else shape_of_chance(claim.at("statement"), claim.at("evidence"));
  for (const Json& each : list(claim.at("statement").at("stopped"))) {
    keys(each, {"objective", "transitions"}, "what stops");
    text(each.at("objective"));
    numbers(each.at("transitions"));
  }
}
