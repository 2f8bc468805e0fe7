"""``python -m wavecascade``: the program."""

import sys

from wavecascade._program import main

sys.exit(main())
