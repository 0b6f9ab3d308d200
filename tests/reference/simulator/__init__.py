# SPDX-License-Identifier: Apache-2.0
"""Independent simulator of camera pictures of printed circuit boards, from optics alone."""
