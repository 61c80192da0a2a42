// How the ground's fields become patches.
