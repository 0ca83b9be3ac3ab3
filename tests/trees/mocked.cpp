// Plays the tests that `mcpn tests --btcpp` has written: each scenario's name, and what the tree returned.
#include <behaviortree_cpp/bt_factory.h>
#include <behaviortree_cpp/contrib/json.hpp>

#include <chrono>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <thread>

namespace
{
BT::NodeStatus never(BT::TreeNode&)
{
  throw std::logic_error("a leaf was not replaced");
}
}  // namespace

int main(int argc, char** argv)
{
  std::ifstream file(argv[2]);
  const auto mocks = nlohmann::json::parse(file);
  for(const auto& scenario : mocks["scenarios"])
  {
    BT::BehaviorTreeFactory factory;
    for(int place = 4; place < argc; ++place)  // a leaf and its ports, as in Grasp:object:force
    {
      std::istringstream said(argv[place]);
      std::string name, port;
      std::getline(said, name, ':');
      BT::PortsList ports;
      while(std::getline(said, port, ':'))
      {
        ports.insert(BT::BidirectionalPort(port));
      }
      factory.registerSimpleAction(name, never, ports);
    }
    factory.loadSubstitutionRuleFromJSON(scenario["rules"].dump());
    factory.registerBehaviorTreeFromFile(argv[1]);
    auto tree = factory.createTree(argv[3]);
    tree.rootBlackboard()->set(mocks["step"].get<std::string>(), 0);
    auto status = tree.tickExactlyOnce();
    for(int tick = 0; tick < 200 && status == BT::NodeStatus::RUNNING; ++tick)
    {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      status = tree.tickExactlyOnce();
    }
    std::cout << scenario["name"].get<std::string>() << ';' << BT::toStr(status) << '\n';
    tree.haltTree();
  }
  return 0;
}
