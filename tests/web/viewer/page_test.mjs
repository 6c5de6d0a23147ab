// The viewer page against a stand-in for the program, which can fail on demand.

import './seen.mjs';
import './hold.mjs';
import './panels.mjs';
import './safety.mjs';
import './mirror.mjs';
import './headset.mjs';
