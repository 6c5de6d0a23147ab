#include "end_request.h"

#include <ros/xmlrpc_manager.h>

namespace palpate::ros1 {

void on_end_request(const std::function<void()>& asked) {
  const auto& server = ros::XMLRPCManager::instance();
  server->unbind("shutdown");
  server->bind("shutdown", [asked](XmlRpc::XmlRpcValue&, XmlRpc::XmlRpcValue& response) {
    asked();
    response[0] = 1;  // done, as roscpp answers
    response[1] = "";
    response[2] = 0;
  });
}

}  // namespace palpate::ros1
