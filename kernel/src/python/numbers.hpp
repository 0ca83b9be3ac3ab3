// Whole numbers of Python as wide ones: exact up to kFarthest, and moved there from beyond.
#pragma once

#include <nanobind/nanobind.h>

#include "wide.hpp"

namespace nanobind::detail {

template <> struct type_caster<mcpn::Wide> {
  NB_TYPE_CASTER(mcpn::Wide, const_name("int"))

  bool from_python(handle source, std::uint8_t, cleanup_list*) noexcept {
    if (!PyLong_Check(source.ptr())) return false;
    int beyond = 0;
    value = PyLong_AsLongLongAndOverflow(source.ptr(), &beyond);
    if (!beyond) return true;
    PyObject* by = PyLong_FromLong(64);
    PyObject* upper = by ? PyNumber_Rshift(source.ptr(), by) : nullptr;
    Py_XDECREF(by);
    if (!upper) {
      PyErr_Clear();
      return false;
    }
    int farther = 0;
    const long long high = PyLong_AsLongLongAndOverflow(upper, &farther);
    Py_DECREF(upper);
    constexpr long long most = 1ll << 62;
    if (farther || high >= most || high < -most) {
      value = beyond > 0 ? mcpn::kFarthest : -mcpn::kFarthest;
    } else {
      value = mcpn::Wide(high) * (mcpn::Wide(1) << 64) + PyLong_AsUnsignedLongLongMask(source.ptr());
    }
    return true;
  }
  static handle from_cpp(mcpn::Wide value, rv_policy, cleanup_list*) noexcept {
    const auto low = static_cast<unsigned long long>(value);
    const auto high = static_cast<long long>(value >> 64);
    if (high == (static_cast<long long>(low) < 0 ? -1 : 0)) return PyLong_FromLongLong(static_cast<long long>(low));
    PyObject* by = PyLong_FromLong(64);
    PyObject* upper = PyLong_FromLongLong(high);
    PyObject* lower = PyLong_FromUnsignedLongLong(low);
    PyObject* moved = by && upper ? PyNumber_Lshift(upper, by) : nullptr;
    PyObject* found = moved && lower ? PyNumber_Or(moved, lower) : nullptr;
    for (PyObject* part : {by, upper, lower, moved}) Py_XDECREF(part);
    return found;
  }
};

}  // namespace nanobind::detail
