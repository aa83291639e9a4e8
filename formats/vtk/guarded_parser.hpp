// VTK's parser of XML, which takes what it finds in a file for true, held to what the file has.
#pragma once

#include "formats/vtk/sources.hpp"

#include <cstdint>
#include <functional>
#include <string>

#include <vtkObjectFactory.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>

class vtkInputStream;

namespace ptet::vtkio {

/// Whether a file can hold so many bytes, compressed or not.
inline bool is_true_size(double bytes, std::uint64_t file_bytes) {
  return bytes <= static_cast<double>(kMaxCompression) * static_cast<double>(file_bytes);
}

/// Empty where there is no such attribute.
std::string attribute(vtkXMLDataElement& element, const char* name);
/// Elements of that name in another.
int count_of(vtkXMLDataElement& parent, const std::string& name);

class GuardedParser : public vtkXMLDataParser {
public:
  static GuardedParser* New() { VTK_STANDARD_NEW_BODY(GuardedParser); }
  using Superclass = vtkXMLDataParser;

  int Parse() override;

  /// Calls `visit` with each word of an array that is text; stops and returns false when it does.
  bool each_word(vtkXMLDataElement& array, const std::function<bool(const std::string&)>& visit);

  /// What the base64 text of an array that is not compressed comes to, without its head.
  std::uint64_t inline_bytes(vtkXMLDataElement& array);

  std::uint64_t file_bytes = 0;
  std::uint64_t array_bytes = 0; ///< that the array read last has, whatever it should have; not of text

private:
  template <class Base>
  void guard(vtkInputStream*& stream);
};

} // namespace ptet::vtkio
