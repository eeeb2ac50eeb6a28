// SPDX-License-Identifier: MIT
// A branch that costs nothing where no lane takes it. Lavapipe does what is in an `if` for all lanes and throws away what was not
// wanted; a loop it leaves once no lane goes round. So what is dear and seldom needed stands in a loop that runs once or not at all.
//
// The other thing that loops want there: Mesa 22 ends all loops of a workgroup after 65 535 turns, whatever they wait for. Who
// could need as many asks afterwards what the loop was for, not the variable that the loop ran on: every compiler knows that a
// loop until `ended` has ended.
// A GPU's compiler sees a loop of one turn there, which is an `if`, where it must take the other for one of many.
#define BRANCH_IF(condition) for (int once = ON_CPU ? int(!(condition)) : 0; once < 1; ++once) if (ON_CPU || (condition))
