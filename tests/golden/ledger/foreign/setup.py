# SPDX-License-Identifier: Apache-2.0
open("drill1.ledger", "w").write("M48\nMETRIC,TZ\n")
