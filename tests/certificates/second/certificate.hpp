// How certificates are read in C++, from docs/certificates.md alone.
#pragma once

#include "net.hpp"
#include "zip.hpp"
