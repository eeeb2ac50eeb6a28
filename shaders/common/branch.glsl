// SPDX-License-Identifier: MIT
// A branch that costs nothing where no lane takes it. Lavapipe does what is in an `if` for all lanes and throws away what was not
// wanted; a loop it leaves once no lane goes round. So what is dear and seldom needed stands in a loop that runs once or not at all.
//
// The other thing that loops want on lavapipe: Mesa 22 ends all loops of a workgroup after 65 535 turns, whatever they wait for. Who
// could need as many asks afterwards what the loop was for, not the variable that the loop ran on: every compiler knows that a
// loop until `ended` has ended.
// Elsewhere the loop always runs exactly once around an `if`, which a compiler unrolls; a loop that may run zero times it would keep
// as a loop.
#define BRANCH_IF(condition) for (int once = ON_CPU ? int(!(condition)) : 0; once < 1; ++once) if (ON_CPU || (condition))
