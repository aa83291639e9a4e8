// Archives for Boost.Serialization's serialize() functions: values only, little-endian, bounded. No type information,
// no tracking, no versions; every count is checked against the bytes left before anything is allocated. Header only:
// no Boost library is linked.
//
//   unsigned number   varint (7 bits a byte, low ones first)
//   string            varint length, bytes
//   vector            varint count, elements
//   class, pair       its members in the order of its serialize()
#pragma once

#include "formats/ptet/bytes.hpp"

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
  void save(const T& value) {
    out_.put_varint(value);
  }
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
  void load(T& value) {
    value = static_cast<T>(in_.get_count("number", std::numeric_limits<T>::max()));
  }
  void load(std::string& text) { text = in_.get_text(in_.get_count("length of text", in_.remaining()), "text"); }
  template <class T>
  void load(std::vector<T>& values) {
    // Every element takes a byte at least.
    values.resize(in_.get_count("number of elements", in_.remaining()));
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
