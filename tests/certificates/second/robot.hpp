// A robot that is given the orders of one event: whether it can take them, and what runs then.
#pragma once

#include "controller.hpp"

inline Names timers(const Controller& of, const Shown& in) {
  Names found;
  for (const auto& [name, held] : of.timed) {
    const auto there = [&](const std::string& each) { return in.objectives.count(each) || in.pending.count(each); };
    if (of.of.at("objectives").members.count(name) && held.empty() ? in.objectives.count(name) > 0 : std::any_of(held.begin(), held.end(), there)) found.insert(name);
  }
  return found;
}

class Robot {
 public:
  Robot(const Controller& of, const Shown& before, const Shown& after, const Texts& event)
      : of_(of), after_(after), running_(before.mode), timers_(timers(of, before)), event_(event) {}

  void takes(const std::vector<std::vector<Order>>& all) {
    if ((event_[0] == "success" || event_[0] == "failure" || event_[0] == "timeout") && timers_.count(event_[1])) ends_ = event_[1];
    for (const auto& section : all) {
      std::size_t at = 0;
      left_.clear();
      released_.clear();
      for (const Order& order : section) {
        static const Texts verbs{"disarm", "stop", "release", "select", "start", "arm"};
        const std::size_t verb = std::size_t(std::find(verbs.begin(), verbs.end(), order.verb) - verbs.begin());
        require(verb < verbs.size(), "an order of no kind");
        agree(at <= verb, "orders are in another order");
        at = verb;
        take(order);
      }
      agree(left_ == released_, "other hardware is released than was held");
    }
    agree(ends_.empty(), "the timer of what ends is not disarmed");
    agree(running_ == after_.mode, "other activities run than the state says");
    agree(timers_ == timers(of_, after_), "other timers run than the state says");
  }

 private:
  Names consumed(const std::string& activity, const std::string& alternative) const {
    return names_in(of_.of.at("activities").at(activity).at("alternatives").at(alternative).at("consumes"));
  }
  // Whether all that it consumes and another activity produces is there.
  bool supplied(const std::string& activity, const std::string& alternative) const {
    for (const std::string& each : consumed(activity, alternative)) {
      const auto makers = of_.makers.find(each);
      if (makers == of_.makers.end()) continue;
      Names others = makers->second;
      others.erase(activity);
      if (!others.empty() && std::none_of(others.begin(), others.end(), [&](const std::string& who) { return running_.count(who); })) return false;
    }
    return true;
  }
  void gives_up(const std::string& activity) {
    for (const std::string& each : consumed(activity, running_.at(activity)))
      if (of_.held.count(each)) left_.insert(each);
  }
  void named(const Order& order) const {
    Names may;
    for (const std::string& each : after_.objectives)
      if (names_in(of_.of.at("objectives").at(each).at("activities")).count(order.activity)) may.insert(each);
    agree(may.empty() ? order.objective.empty() : may.count(order.objective) > 0, "an activity that is said to be of another objective");
  }
  void take(const Order& order) {
    const std::string& who = order.activity;
    if (order.verb == "disarm") {
      agree(timers_.erase(order.objective), "a timer is disarmed that does not run");
      agree(event_[0] != "out of service" && event_[0] != "repaired" && event_[0] != "detected", "hardware disarms a timer");
      if (order.objective == ends_) ends_.clear();
    } else if (order.verb == "arm") {
      agree(timers_.insert(order.objective).second, "a timer is armed that runs");
    } else if (order.verb == "stop") {
      agree(running_.count(who), "who does not run is stopped");
      agree(supplied(who, running_.at(who)), "who is stopped has lost what it consumes");
      gives_up(who);
      running_.erase(who);
    } else if (order.verb == "release") {
      agree(released_.insert(order.hardware).second, "hardware is released twice");
    } else if (order.verb == "select") {
      agree(selected_.emplace(who, order.alternative).second, "an activity is selected twice");
      agree(after_.mode.count(who) && after_.mode.at(who) == order.alternative, "an alternative is selected that does not run then");
      named(order);
      if (running_.count(who)) { gives_up(who); running_[who] = order.alternative; }
    } else {
      agree(!running_.count(who) && selected_.count(who), "who runs, or has no alternative, is started");
      agree(supplied(who, selected_.at(who)), "who is started has not what it consumes");
      named(order);
      running_[who] = selected_.at(who);
    }
  }

  const Controller& of_;
  const Shown& after_;
  Modes running_, selected_;
  Names timers_, left_, released_;
  Texts event_;
  std::string ends_;
};
