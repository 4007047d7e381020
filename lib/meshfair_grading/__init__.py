"""Assignments that check themselves, and the marking of a class.

The same checks run in two places. In the student's notebook they run in the
notebook's own process, on meshes that the student sees; in ``meshfair grade``
the student's code runs in a process of its own with limits, and the checks,
in the teacher's process, send it meshes that the student has not seen.

==============  ==========================================================
``source``      an instructor's file, and the student's files made from it
``assignment``  tasks, points, checks; marks a student
``outcomes``    what a check found, and what that is worth
``expect``      comparisons that explain what is wrong
``mistakes``    known mistakes, by the values that come out of them
``rounding``    what is the same up to rounding
``students``    a student's functions, in this process or in another one
``answers``     what a function returned, as plain data
``rules``       which imports and calls an assignment allows
``loading``     a student's file, run without what is not allowed
``standin``     right functions in place of wrong ones, for the tasks after
``meshes``      the meshes that students have not seen
``arguments``   what a call is given, in memory that both processes see
``protocol``    plain data between the two processes
``view``        the files that the other process sees
``kernel``      what it may not ask of the kernel
``walls``       bubblewrap's walls around it
``isolation``   starts it, with limits, and ends it
``watch``       limits for all of its processes together
``child``       what runs inside
``submissions`` what a class handed in, whatever it is called
``marking``     a whole class: in parallel, going on where it stopped
``gradebook``   the results on the disk
``printable``   texts that a student has a say in, made fit to be shown
``feedback``    the report as text, Markdown and HTML
``notebook``    pictures of a student's result
``generate``    ``python -m meshfair_grading.generate``
``similar``     submissions that look alike
``overview``    what the teacher alone gets
``explain``     how one student's mark came about
``command``     ``meshfair grade``
``handout``     ``meshfair handout``
==============  ==========================================================
"""
