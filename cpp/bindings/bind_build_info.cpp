// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <ceres/version.h>
#include <dlfcn.h>

#include <Eigen/Core>
#include <string>
#include <thread>

#include "bindings.h"

// Given by CMake for this file alone; other build systems may leave them out.
#ifndef RAYLIGN_BUILD_TYPE
#define RAYLIGN_BUILD_TYPE "unknown"
#endif
#ifndef RAYLIGN_CXX_FLAGS
#define RAYLIGN_CXX_FLAGS "unknown"
#endif
#ifndef RAYLIGN_OPENCV_VERSION
#define RAYLIGN_OPENCV_VERSION "unknown"
#endif

namespace raylign::python {
namespace {

namespace py = pybind11;

std::string eigen_version() {
  return std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
         std::to_string(EIGEN_MINOR_VERSION);
}

std::string compiler() {
#if defined(__clang__)
  return "Clang " __clang_version__;
#elif defined(__GNUC__)
  return "GCC " __VERSION__;
#else
  return "unknown";
#endif
}

std::string file_name_of(const void* symbol) {
  Dl_info info{};
  if (symbol == nullptr || dladdr(symbol, &info) == 0 || info.dli_fname == nullptr) return "";
  const std::string path = info.dli_fname;
  return path.substr(path.find_last_of('/') + 1);
}

// The BLAS that Ceres' dense solvers got from the dynamic linker: a run-time matter (Debian's
// update-alternatives), so it is asked of the process and not of CMake.
py::dict blas() {
  py::dict result;
  result["library"] = file_name_of(dlsym(RTLD_DEFAULT, "dgemm_"));
  using GetConfig = char* (*)();
  const auto config = reinterpret_cast<GetConfig>(dlsym(RTLD_DEFAULT, "openblas_get_config"));
  result["config"] = config == nullptr ? std::string() : std::string(config());
  return result;
}

py::list cpu_features() {
  py::list features;
#if defined(__x86_64__) && (defined(__GNUC__) || defined(__clang__))
  __builtin_cpu_init();
  if (__builtin_cpu_supports("sse4.2")) features.append("sse4.2");
  if (__builtin_cpu_supports("avx")) features.append("avx");
  if (__builtin_cpu_supports("fma")) features.append("fma");
  if (__builtin_cpu_supports("avx2")) features.append("avx2");
  if (__builtin_cpu_supports("avx512f")) features.append("avx512f");
  if (__builtin_cpu_supports("avx512dq")) features.append("avx512dq");
  if (__builtin_cpu_supports("avx512vl")) features.append("avx512vl");
#elif defined(__aarch64__)
  features.append("neon");
#endif
  return features;
}

py::dict build_info() {
  py::dict info;
  info["raylign"] = RAYLIGN_VERSION;
  info["ceres"] = CERES_VERSION_STRING;
  info["eigen"] = eigen_version();
  info["eigen_simd"] = Eigen::SimdInstructionSetsInUse();
  info["opencv_linked"] = RAYLIGN_OPENCV_VERSION;
  info["pybind11"] =
      std::to_string(PYBIND11_VERSION_MAJOR) + "." + std::to_string(PYBIND11_VERSION_MINOR);
  info["compiler"] = compiler();
  info["cxx_standard"] = __cplusplus / 100 % 100;
  info["build_type"] = RAYLIGN_BUILD_TYPE;
  info["cxx_flags"] = RAYLIGN_CXX_FLAGS;
#ifdef NDEBUG
  info["assertions"] = false;
#else
  info["assertions"] = true;
#endif
  info["blas"] = blas();
  info["cpu_features"] = cpu_features();
  info["hardware_threads"] = std::thread::hardware_concurrency();
  return info;
}

}  // namespace

void bind_build_info(py::module_& m) {
  m.def("build_info", &build_info,
        "Versions, compiler, flags, BLAS and CPU features of this build and process, as a dict.");
}

}  // namespace raylign::python
