/// \file
/// Field descriptions of message types, as in rosapi.
#pragma once

#include <string>

#include <palpate/rosbridge/message.h>

namespace palpate {

/// \name rosapi/TypeDef of a type, then of its nested types, each once, depth first
/// Each field has its array length (-1: no array, 0: variable) and its default value as Python prints it.
/// Constants are sorted by name. \throws Refusal for an unknown type.
/// @{
/// Returns an empty list for a built-in ROS type ("float64").
Json message_details(const std::string& type);
Json service_request_details(const std::string& service);
Json service_response_details(const std::string& service);
/// @}

}  // namespace palpate
