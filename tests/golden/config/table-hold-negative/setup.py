# SPDX-License-Identifier: Apache-2.0
import golden_table
golden_table.write()
