"""What nodes of trees are: as files say them, and by the table of nodes in the versions of each library."""
