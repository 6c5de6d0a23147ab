/// \file
/// What a type is made of, as rosapi tells it.
#pragma once

#include <string>

#include <palpate/rosbridge/message.h>

namespace palpate {

/// \name rosapi/TypeDef of a type, then those of what it is made of, each once, depth first
/// A field is told with the length of its array (-1: none, 0: any), and what it is before it is set, as
/// Python prints it. Constants are in the order of their names. \throws Refusal for a type that is not known
/// here.
/// @{
/// Of a message; none of what ROS has by itself ("float64").
Json message_details(const std::string& type);
Json service_request_details(const std::string& service);
Json service_response_details(const std::string& service);
/// @}

}  // namespace palpate
