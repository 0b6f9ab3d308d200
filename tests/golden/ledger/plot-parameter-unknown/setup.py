# SPDX-License-Identifier: Apache-2.0
import golden_ledger
golden_ledger.two_nights()
