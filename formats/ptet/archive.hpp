// Archives for Boost.Serialization's serialize() functions: values only, little-endian, bounded. No type information,
// no tracking, no versions; every count is checked against the bytes left before anything is allocated. Header only:
// no Boost library is linked.
//
//   unsigned number   varint (7 bits a byte, low ones first)
//   float, double     its bits, 4 or 8 bytes
//   bool, char        a byte
//   string            varint length, bytes
//   vector            varint count, elements
//   array             elements
//   class, pair       its members in the order of its serialize()
#pragma once

#include "formats/ptet/bytes.hpp"

#include <array>
#include <concepts>

#include <boost/mpl/bool.hpp>
#include <boost/serialization/nvp.hpp>
#include <boost/serialization/serialization.hpp>
#include <boost/serialization/utility.hpp>

namespace ptet::file {

class OutputArchive {
public:
  using is_saving = boost::mpl::true_;
  using is_loading = boost::mpl::false_;

  explicit OutputArchive(ByteWriter& out) : out_(out) {}

  template <class T>
  OutputArchive& operator&(const T& value) {
    save(value);
    return *this;
  }
  template <class T>
  OutputArchive& operator<<(const T& value) {
    return *this & value;
  }

private:
  template <std::unsigned_integral T>
  requires(!std::same_as<T, bool> && !std::same_as<T, char>) void save(const T& value) { out_.put_varint(value); }
  void save(bool value) { out_.put(static_cast<std::uint8_t>(value)); }
  void save(char value) { out_.put(static_cast<std::uint8_t>(value)); }
  void save(float value) { out_.put(std::bit_cast<std::uint32_t>(value)); }
  void save(double value) { out_.put(value); }
  void save(const std::string& text) {
    out_.put_varint(text.size());
    out_.put_text(text);
  }
  template <class T>
  void save(const std::vector<T>& values) {
    out_.put_varint(values.size());
    for (const T& value : values)
      save(value);
  }
  template <class T, std::size_t N>
  void save(const std::array<T, N>& values) {
    for (const T& value : values)
      save(value);
  }
  template <class T>
  void save(const boost::serialization::nvp<T>& named) {
    save(named.const_value());
  }
  template <class T>
  requires std::is_class_v<T>
  void save(const T& object) { boost::serialization::serialize_adl(*this, const_cast<T&>(object), 0); }

  ByteWriter& out_;
};

class InputArchive {
public:
  using is_saving = boost::mpl::false_;
  using is_loading = boost::mpl::true_;

  explicit InputArchive(ByteReader& in) : in_(in) {}

  template <class T>
  InputArchive& operator&(T&& value) {
    load(value);
    return *this;
  }
  template <class T>
  InputArchive& operator>>(T&& value) {
    return *this & value;
  }

private:
  template <std::unsigned_integral T>
  requires(!std::same_as<T, bool> && !std::same_as<T, char>) void load(T& value) {
    value = static_cast<T>(in_.get_count("number", std::numeric_limits<T>::max()));
  }
  void load(bool& value) { value = in_.get<std::uint8_t>("truth value") != 0; }
  void load(char& value) { value = static_cast<char>(in_.get<std::uint8_t>("byte")); }
  void load(float& value) { value = std::bit_cast<float>(in_.get<std::uint32_t>("number")); }
  void load(double& value) { value = in_.get<double>("number"); }
  void load(std::string& text) { text = in_.get_text(in_.get_count("length of text", in_.remaining()), "text"); }
  template <class T>
  void load(std::vector<T>& values) {
    // Every element takes a byte at least.
    values.resize(in_.get_count("number of elements", in_.remaining()));
    for (T& value : values)
      load(value);
  }
  template <class T, std::size_t N>
  void load(std::array<T, N>& values) {
    for (T& value : values)
      load(value);
  }
  template <class T>
  void load(const boost::serialization::nvp<T>& named) {
    load(named.value());
  }
  template <class T>
  requires std::is_class_v<T>
  void load(T& object) { boost::serialization::serialize_adl(*this, object, 0); }

  ByteReader& in_;
};

} // namespace ptet::file
