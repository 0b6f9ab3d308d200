# SPDX-License-Identifier: Apache-2.0
# Headers for Doxygen. A docblock is plain text to us, so that a sign in it is no command.
/^ *\/\/\/|\/\/\/</ {
  s/\\/\\\\/g
  s/[@#&]/\\&/g
  # The "<" of "///<" is Doxygen's.
  s/([^\/])</\1\\</g
  s/::/\\::/g
  s/ \.\.$/ .../
  # Its parts each on a line of their own: "In  x, in mm".
  s/^( *\/\/\/) *(In|Out|Fails|Source|See|Equation) +/\1 <br><b>\2<\/b> /
}
# Doxygen 1.9.4 does not find a declaration with a constraint again, and warns of the definition.
/^template <class D>$/ {
  N
  /Quantity<D>::in_/ {
    :next
    N
    /\n\}/!b next
    d
  }
}
