// Plays a tree in BehaviorTree.CPP with leaves that answer by chance; one line for each tick.
#include <behaviortree_cpp/bt_factory.h>

#include <algorithm>
#include <iostream>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace
{
std::mt19937 chance;
std::vector<std::string> seen;
std::vector<const BT::TreeNode*> running;  // leaves that run, in the order in which they began
const BT::TreeNode* ending = nullptr;      // the one of them that ends in this tick
BT::NodeStatus end = BT::NodeStatus::SUCCESS;

unsigned draw(unsigned below)
{
  return std::uniform_int_distribution<unsigned>(0, below - 1)(chance);
}

BT::NodeStatus either()
{
  return draw(2) == 0 ? BT::NodeStatus::SUCCESS : BT::NodeStatus::FAILURE;
}

class Leaf : public BT::StatefulActionNode
{
public:
  using BT::StatefulActionNode::StatefulActionNode;
  static BT::PortsList providedPorts()
  {
    return {};
  }
  BT::NodeStatus onStart() override
  {
    if(draw(3) != 0)
    {
      running.push_back(this);
      return BT::NodeStatus::RUNNING;
    }
    return told(either());
  }
  BT::NodeStatus onRunning() override
  {
    if(ending != this)
    {
      return BT::NodeStatus::RUNNING;
    }
    gone();
    return told(end);
  }
  void onHalted() override
  {
    gone();
  }

private:
  void gone()
  {
    running.erase(std::remove(running.begin(), running.end(), this), running.end());
  }
  BT::NodeStatus told(BT::NodeStatus status)
  {
    seen.push_back(registrationName() + (status == BT::NodeStatus::SUCCESS ? ":success" : ":failure"));
    return status;
  }
};
}  // namespace

int main(int, char** argv)
{
  chance.seed(static_cast<unsigned>(std::stoul(argv[2])));
  BT::BehaviorTreeFactory factory;
  for(const char* name : { "a", "b", "c", "d" })
  {
    factory.registerNodeType<Leaf>(name);
  }
  for(const char* name : { "IsX", "IsY" })
  {
    factory.registerSimpleCondition(name, [](BT::TreeNode&) { return either(); });
  }
  auto tree = factory.createTreeFromFile(argv[1]);
  for(unsigned tick = 0; tick < std::stoul(argv[3]); ++tick)
  {
    seen.clear();
    const auto place = draw(static_cast<unsigned>(running.size()) + 1);
    ending = place < running.size() ? running[place] : nullptr;
    end = either();
    const auto status = tree.tickExactlyOnce();
    std::cout << BT::toStr(status) << ';';
    for(const auto& each : seen)
    {
      std::cout << each << ' ';
    }
    std::multiset<std::string> names;
    for(const auto* leaf : running)
    {
      names.insert(leaf->registrationName());
    }
    std::cout << ';';
    for(const auto& name : names)
    {
      std::cout << name << ' ';
    }
    std::cout << '\n';
    if(status != BT::NodeStatus::RUNNING)
    {
      break;
    }
  }
  return 0;
}
